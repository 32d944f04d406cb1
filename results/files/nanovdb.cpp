// Writes small NanoVDB files with NanoVDB's own headers. Each value is of a closed form, which the tests of the reader
// repeat.
//
//   write FOLDER         the test files
//   write FOLDER big     large grids, to time the reader

#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <fstream>
#include <iostream>
#include <string>
#include <type_traits>
#include <vector>

#include <nanovdb/util/GridBuilder.h>
#include <nanovdb/util/IO.h>

using namespace nanovdb;
using nanovdb::io::Codec;
using Handle = GridHandle<HostBuffer>;

static std::string folder;

// The builder has no public way to make tiles of the root. Explicit instantiation may name private members.
template<auto Member>
struct Opened {
    friend auto &root_of(GridBuilder<float> &builder) { return builder.*Member; }
};
template struct Opened<&GridBuilder<float>::mRoot>;
auto &root_of(GridBuilder<float> &builder);

static int modulo(int a, int b) { return (a % b + b) % b; }

static double ball(int x, int y, int z) {
    const bool inside = (x + 6) * (x + 6) + (y + 4) * (y + 4) + (z - 9) * (z - 9) < 30;
    return inside ? (modulo(7 * x + 11 * y + 13 * z, 29) + 1) / 29.0 : 0.0;
}

// Six tiles of 8^3.
static double slab(int x, int y, int z) {
    return x >= -16 && x < 8 && y >= 16 && y < 32 && z >= 40 && z < 48 ? 0.5 : 0.0;
}

// Five leaves whose values have 2, 4, 16, 256 and 65536 levels: FpN stores them with 1, 2, 4, 8 and 16 bits.
static double steps(int x, int y, int z) {
    if (x < 16 || x >= 56 || y < 0 || y >= 8 || z < 0 || z >= 8) return 0.0;
    const int levels[] = {2, 4, 16, 256, 65536}, n = (x - 16) / 8;
    const double most = n == 4 ? 100.0 : 1.0;
    return (7919 * x + 104729 * y + 1299709 * z) % levels[n] / (levels[n] - 1.0) * most;
}

static double field(int x, int y, int z) { return ball(x, y, z) + slab(x, y, z) + steps(x, y, z); }

// Every value in the box that is not the background.
template<typename T, typename Builder, typename F>
static void fill(Builder &builder, CoordBBox box, const F &value) {
    builder([&](const Coord &at) { return T(value(at[0], at[1], at[2])); }, box);
}

static const CoordBBox BALL(Coord(-16, -16, 0), Coord(7, 7, 15));
static const CoordBBox SLAB(Coord(-16, 16, 40), Coord(7, 31, 47));
static const CoordBBox STEPS(Coord(16, 0, 0), Coord(55, 7, 7));

template<typename T, typename Build>
static Handle whole(const std::string &name, float tolerance = -1.0f) {
    GridBuilder<T, Build> builder(T(0), GridClass::FogVolume);
    for (const CoordBBox &box : {BALL, SLAB, STEPS}) fill<T>(builder, box, field);
    return builder.getHandle(0.25, Vec3d(1.0, 2.0, 3.0), name, AbsDiff(tolerance));
}

static void put(const std::string &name, const Handle &handle, Codec codec) {
    io::writeGrid(folder + "/" + name + ".nvdb", handle, codec);
}

static void types() {
    put("ok-float-none", whole<float, float>("density"), Codec::NONE);
    put("ok-float-zip", whole<float, float>("density"), Codec::ZIP);
    put("ok-float-blosc", whole<float, float>("density"), Codec::BLOSC);
    put("ok-double-zip", whole<double, double>("density"), Codec::ZIP);
    put("ok-double-blosc", whole<double, double>("density"), Codec::BLOSC);
    put("ok-fp4-zip", whole<float, Fp4>("density"), Codec::ZIP);
    put("ok-fp8-blosc", whole<float, Fp8>("density"), Codec::BLOSC);
    put("ok-fp16-zip", whole<float, Fp16>("density"), Codec::ZIP);
    put("ok-fpn-zip", whole<float, FpN>("density", 0.002f), Codec::ZIP);
    const Handle raw = whole<float, float>("density");
    std::ofstream file(folder + "/ok-raw.nvdb", std::ios::binary);
    file.write(reinterpret_cast<const char *>(raw.data()), raw.size());
}

// One segment of two grids, and two segments of one grid each, of different codecs.
static void several() {
    GridBuilder<float> builder(0.0f);
    fill<float>(builder, BALL, [](int x, int y, int z) { return 1000.0 * ball(x, y, z); });
    std::vector<Handle> both;
    both.push_back(whole<float, float>("density"));
    both.push_back(builder.getHandle(0.5, Vec3d(0.0), "temperature"));
    io::writeGrids(folder + "/ok-two-grids.nvdb", both, Codec::ZIP);
    std::ofstream segments(folder + "/ok-two-segments.nvdb", std::ios::binary);
    io::writeGrid(segments, both[1], Codec::BLOSC);
    io::writeGrid(segments, both[0], Codec::ZIP);
}

// A sphere of radius 12 with a band of 3 samples: what is farther inside or outside is 3 or -3, partly in inactive
// tiles.
static void level_set() {
    GridBuilder<float> builder(3.0f, GridClass::LevelSet);
    const auto distance = [](int x, int y, int z) {
        const int square = (x + 6) * (x + 6) + (y + 4) * (y + 4) + (z - 9) * (z - 9);
        const float d = float(std::sqrt(double(square)) - 12.0);
        return d > -3.0f && d < 3.0f ? d : 3.0f;
    };
    fill<float>(builder, CoordBBox(Coord(-24), Coord(31)), distance);
    builder.sdfToLevelSet();
    put("ok-level-set", builder.getHandle(0.1, Vec3d(0.0), "surface"), Codec::ZIP);
}

static void sheared() {
    const double rows[3][3] = {{0.5, 0.25, 0.0}, {-0.125, 0.75, 0.0625}, {0.0, 0.3, 1.5}};
    const double move[3] = {7.0, -8.0, 9.5};
    double columns[3][3], none[3][3] = {};
    for (int i = 0; i < 3; ++i) for (int j = 0; j < 3; ++j) columns[j][i] = rows[i][j];
    Map map;
    map.set(columns, none, move, 1.0);
    GridBuilder<float> builder(0.0f);
    fill<float>(builder, BALL, ball);
    const Handle handle = builder.getHandle(map, "density");
    // NanoVDB must agree on what the map means.
    for (const Vec3d at : {Vec3d(0, 0, 0), Vec3d(1, 0, 0), Vec3d(0, 1, 0), Vec3d(0, 0, 1), Vec3d(-3, 5, 7)}) {
        const Vec3d found = handle.grid<float>()->indexToWorld(at);
        for (int i = 0; i < 3; ++i) {
            const double wanted = rows[i][0] * at[0] + rows[i][1] * at[1] + rows[i][2] * at[2] + move[i];
            if (std::abs(found[i] - wanted) > 1e-12) { std::cerr << "the map is another\n"; std::exit(1); }
        }
    }
    put("ok-sheared", handle, Codec::ZIP);
}

static void background() {
    GridBuilder<float> builder(0.125f);
    fill<float>(builder, BALL, [](int x, int y, int z) { return ball(x, y, z) + 0.125; });
    put("ok-background", builder.getHandle(1.0, Vec3d(0.0), "density"), Codec::BLOSC);
}

// Tiles of every level: two at the root, one active and one not; one of 128^3; six of 8^3.
static void tiles() {
    GridBuilder<float> builder(0.0f, GridClass::FogVolume);
    fill<float>(builder, SLAB, slab);
    fill<float>(builder, CoordBBox(Coord(-384, 128, 256), Coord(-257, 255, 383)), [](int, int, int) { return 0.75; });
    auto &table = root_of(builder).mTable;
    using Tile = typename std::decay_t<decltype(table)>::mapped_type;
    table[Coord(-8192, 4096, -4096)] = Tile(0.25f, true);
    table[Coord(0, -4096, 12288)] = Tile(-0.375f, false);
    put("ok-tiles", builder.getHandle(1.0, Vec3d(0.0), "density"), Codec::BLOSC);
}

static void no_floats() {
    GridBuilder<int32_t> builder(0);
    fill<int32_t>(builder, BALL, [](int x, int y, int z) { return 29.0 * ball(x, y, z); });
    put("bad-int32", builder.getHandle(1.0, Vec3d(0.0), "ids"), Codec::ZIP);
}

// A ball of 5.6 million samples.
static void big() {
    GridBuilder<float> builder(0.0f, GridClass::FogVolume);
    const auto value = [](int x, int y, int z) {
        return x * x + y * y + z * z < 110 * 110 ? (modulo(7 * x + 11 * y + 13 * z, 29) + 1) / 29.0 : 0.0;
    };
    fill<float>(builder, CoordBBox(Coord(-110), Coord(110)), value);
    const Handle handle = builder.getHandle(1.0, Vec3d(0.0), "density");
    put("big-none", handle, Codec::NONE);
    put("big-zip", handle, Codec::ZIP);
    put("big-blosc", handle, Codec::BLOSC);
}

int main(int count, char **words) {
    if (count < 2) return 1;
    folder = words[1];
    if (count > 2) {
        big();
        return 0;
    }
    types();
    several();
    level_set();
    sheared();
    background();
    tiles();
    no_floats();
}
