//! Binning of many casters: many workgroups gather the casters that meet a tile, in drawing order, and sums of entries and of bounds exceed
//! 32 bits.

use crate::support::scenes::{self, Random};
use crate::support::{ask, built, gpu_test, is_left_out, skipped, some};
use gobo::Error;
use gobo::gpu::{Buffer, Constants, Context, Kernel, groups, push_struct};
use gobo::maps::{BinTotals, Bins, Compact, Entries, Maps, OpaqueMaps, Use};
use gobo::reference::twin::compact::{compact, mark, scan};
use gobo::scene::Particle;
use gobo::shaders::{self, set};
use gobo::world::World;
use rand::seq::SliceRandom;

/// Casters per block, and per thread's word.
const BLOCK: usize = 2048;
const WORD: usize = 32;

/// Asserts that the passes gather the same casters as the twin, for two maps with these drawing orders, of which only the casters marked as
/// met are kept.
fn gathers(context: &Context, what: &str, capacity: usize, count: usize, maps: [(&[u32], &[bool]); 2]) {
    let met: Vec<u32> = maps.iter().flat_map(|(_, met)| met.iter().map(|m| u32::from(*m))).collect();
    // Past the actual casters, the buffer holds values that must not be read.
    let padded = |order: &[u32]| [order, &vec![u32::MAX; capacity - count]].concat();
    let orders: Vec<u32> = maps.iter().flat_map(|(order, _)| padded(order)).collect();
    let met = Buffer::with_data(context, "met", &met).expect("room");
    let orders = Buffer::with_data(context, "orders", &orders).expect("room");
    let passes = Compact::new(context, &met, &orders, capacity as u32, 2).expect("room");
    for run in ["once", "again"] {
        context.submit(|commands| passes.record(commands, count as u32)).expect("submitted");
        let drawn: Vec<u32> = passes.drawn.read(2 * capacity).expect("read");
        let draws: Vec<[u32; 4]> = passes.draws.read(2).expect("read");
        for (map, (order, met)) in maps.iter().enumerate() {
            let (words, blocks) = mark(order, met);
            let (before, total) = scan(&blocks);
            let expected = compact(order, &words, &before, total);
            // The twin must equal the definition: the casters met, in drawing order.
            assert!(expected.iter().eq(order.iter().filter(|c| met[**c as usize])), "{what}: the twin of map {map}");
            assert_eq!(draws[map], [6 * total, 1, 0, 0], "{what}, {run}: map {map}");
            let found = &drawn[map * capacity..][..total as usize];
            let first = found.iter().zip(&expected).position(|(a, b)| a != b);
            assert!(first.is_none(), "{what}, {run}: map {map} differs from place {first:?} on");
        }
    }
}

#[test]
fn what_is_met_is_gathered_in_drawing_order() {
    gpu_test("what_is_met_is_gathered_in_drawing_order", |context| {
        let mut random = Random::new(51);
        // Counts around a word, a block and the blocks of one scan workgroup; then one unrelated count.
        let scan_blocks = 64 * BLOCK;
        let counts = [0, 1, WORD - 1, WORD, WORD + 1, BLOCK - 1, BLOCK, BLOCK + 1, 3 * BLOCK + 77, 100_003];
        for count in counts.into_iter().chain(some([scan_blocks + 1, scan_blocks - 1, scan_blocks, 300_000], 1)) {
            let by_index: Vec<u32> = (0..count as u32).collect();
            let mut shuffled = by_index.clone();
            shuffled.shuffle(&mut random.generator());
            let all = vec![true; count];
            let none = vec![false; count];
            let mut one = none.clone();
            if let Some(last) = one.last_mut() {
                *last = true;
            }
            let half: Vec<bool> = (0..count).map(|_| random.bits() & 1 == 1).collect();
            let ends: Vec<bool> = (0..count).map(|i| i % BLOCK == 0 || i % BLOCK == BLOCK - 1).collect();
            let few: Vec<bool> = (0..count).map(|_| random.bits().is_multiple_of(1000)).collect();
            for (what, maps) in [
                ("all and none", [(&by_index[..], &all[..]), (&shuffled, &none)]),
                ("none and all", [(&by_index, &none), (&shuffled, &all)]),
                ("the last and half", [(&by_index, &one), (&shuffled, &half)]),
                ("ends of blocks and few", [(&by_index, &ends), (&shuffled, &few)]),
            ] {
                gathers(context, &format!("{what} of {count}"), count + 5, count, maps);
            }
        }
    });
}

push_struct! {
    /// Push constants of glsl/maps/bins/place.comp, with the same name as there.
    struct BinPush { caster_count: u32, capacity: u32, room: u32, mark: u32, map_count: u32 }
}

/// The tiles have the same entries when workgroups count locally before counting and scattering globally, as devices do for very many
/// casters; with as many threads per caster as any device uses; and with the fullest tiles first. In that order each tile comes before all
/// tiles with less than four fifths of its casters.
#[test]
fn tiles_have_the_same_entries_however_they_are_counted() {
    gpu_test("tiles_have_the_same_entries_however_they_are_counted", |context| {
        let mut scene = scenes::random();
        // Enough casters for one locally counting workgroup and part of a second, or with 4 threads per caster for two and part of a third;
        // large casters among small ones.
        let mut random = Random::new(53);
        let some = scene.particles.clone();
        while scene.particles.len() < 2 * 512 + 77 {
            let mut particle = some[random.bits() as usize % some.len()];
            particle.position = particle.position.map(|x| x + random.between(-0.5, 0.5));
            particle.radius *= random.between(0.05, 1.5);
            scene.particles.push(particle);
        }
        let world = World::new(context, &scene).expect("room for the scene");
        // The map has more tiles than the one workgroup that sorts them fullest first has threads.
        let mut maps = Maps::new(context, &world, 128, OpaqueMaps::SHARED).expect("room for the maps");
        context.submit(|commands| maps.record(commands, &world).expect("its lights")).expect("submitted");
        let (casters, tiles) = (world.caster_count() as usize, 256);
        let capacity = casters * tiles;
        let mut all = Vec::new();
        let one_by_one = [&shaders::bins::COUNT_TALLY_0, &shaders::bins::SCATTER_TALLY_0];
        let tallied = [&shaders::bins::COUNT_TALLY_1, &shaders::bins::SCATTER_TALLY_1];
        for (shaders, fullest_first, lanes, threads, turns, room) in [
            (one_by_one, false, 1, 64, 1, 0),
            (one_by_one, true, 16, 64, 1, 0),
            (tallied, true, 1, 128, 8, 0),
            (tallied, false, 4, 128, 16, 0),
            // If each tile has the same capacity, its entries are not counted beforehand.
            (one_by_one, true, 1, 64, 1, casters),
            (one_by_one, false, 16, 64, 1, casters),
        ] {
            let buffer = |name, words: usize| Buffer::with_data(context, name, &vec![0u32; words]).expect("room");
            let [counts, cursors, horizon] = ["counts", "cursors", "horizon"].map(|n| buffer(n, tiles));
            let parts = buffer("parts", 4 * 2 * tiles);
            let met = buffer("met", casters);
            let (totals, entries) = (buffer("totals", size_of::<BinTotals>() / 4), buffer("entries", 2 * capacity));
            let set = set::Bins {
                counts: &counts,
                parts: &parts,
                cursors: &cursors,
                totals: &totals,
                entries: &entries,
                met: &met,
                horizon: &horizon,
                slots: &horizon,
            };
            let set = set.bind(context, "bins").expect("a set");
            let constants = Constants::new()
                .set(shaders::constant::TILE_LANES, lanes)
                .set(shaders::constant::TALLY_THREADS, threads as u32)
                .set(shaders::constant::TALLY_TURNS, turns as u32)
                .set(shaders::constant::THREADS, 128)
                .set(shaders::constant::WORKGROUP, 128)
                .set(shaders::constant::PARTS, 1 + u32::from(fullest_first))
                .set(shaders::constant::EMPTY_PARTS, u32::from(fullest_first));
            let push = BinPush {
                caster_count: casters as u32,
                capacity: capacity as u32,
                room: room as u32,
                mark: 1,
                map_count: 1,
            };
            let caster_groups = (casters * lanes as usize).div_ceil(threads * turns) as u32;
            let [count, scatter] = shaders.map(|shader| (shader, caster_groups));
            let place = if fullest_first {
                (&shaders::bins::PLACE_FULLEST_LISTED_0, 1)
            } else {
                (&shaders::bins::PLACE, tiles as u32 / 64)
            };
            for (shader, groups) in if room > 0 { vec![scatter, place] } else { vec![count, place, scatter] } {
                let kernel = Kernel::compute(context, shader, &[maps.scene(), &set], &constants).expect("made");
                context.submit(|c| c.pass("bins", |pass| pass.dispatch(&kernel, &push, [groups, 1, 1]))).expect("done");
            }
            let found: BinTotals = totals.read(1).expect("read")[0];
            let entries: Vec<[u32; 2]> = entries.read(capacity).expect("read");
            let mut binned = vec![Vec::new(); tiles];
            let mut least = u32::MAX;
            for [tile, _, first, count] in parts.read::<[u32; 4]>(found.parts as usize).expect("read") {
                assert!(!fullest_first || 4 * u64::from(count) <= 5 * u64::from(least), "{count} behind {least}");
                least = least.min(count);
                binned[tile as usize] = entries[first as usize..][..count as usize].to_vec();
                binned[tile as usize].sort_unstable();
            }
            let counts: Vec<u32> = counts.read(tiles).expect("read");
            assert!(binned.iter().map(Vec::len).eq(counts.iter().map(|count| *count as usize)));
            assert_eq!(Some(&found.fullest), counts.iter().max());
            let used = counts.iter().filter(|count| **count > 0).count();
            assert_eq!(found.parts as usize, if fullest_first { 2 * used + tiles - used } else { used });
            all.push((binned, met.read::<u32>(casters).expect("read")));
        }
        assert!(all[0].0.iter().map(Vec::len).sum::<usize>() > 2 * casters, "tiles that share casters");
        assert!(all.iter().all(|one| *one == all[0]));
    });
}

push_struct! {
    /// Push constants of glsl/maps/detail/choose.comp.
    struct ChoosePush { tile_count: u32, across: u32, block_count: u32 }
}

/// The chosen blocks are listed by ascending slot. Placing them fullest first gives the same parts as placing them in any order, whether or
/// not each block has a fixed capacity.
#[test]
fn blocks_are_listed_fullest_first() {
    gpu_test("blocks_are_listed_fullest_first", |context| {
        const TILES: usize = 64;
        let world = World::new(context, &scenes::random()).expect("room for the scene");
        let maps = Maps::new(context, &world, 64, OpaqueMaps::SHARED).expect("room for the maps");
        let mut random = Random::new(57);
        let buffer = |name, words: &[u32]| Buffer::with_data(context, name, words).expect("room");
        for (block_count, room) in [(64u32, 100u32), (700, 5000), (2500, 0), (4096, 5000)] {
            let survey = |tile: usize, bits: u32| [[0, 0xFFFF, bits & 0xFFFF][tile % 3], bits >> 12, bits >> 16];
            let surveys: Vec<[u32; 3]> = (0..TILES).map(|tile| survey(tile, random.bits())).collect();
            let surveys = buffer("surveys", surveys.as_flattened());
            let listed = buffer("listed", &vec![0; block_count as usize + 1]);
            let of_detail = set::Detail { surveys: &surveys, listed: &listed }.bind(context, "detail").expect("a set");
            let [slots, other] = [buffer("slots", &[0; TILES * 64]), buffer("other", &[0; 64])];
            let totals = || buffer("totals", &[0; size_of::<BinTotals>() / 4]);
            // The kernel reads only the set's totals and slots; any buffer may be bound to the other bindings.
            let chosen = totals();
            let bins = set::Bins {
                counts: &other,
                parts: &other,
                cursors: &other,
                totals: &chosen,
                entries: &other,
                met: &other,
                horizon: &other,
                slots: &slots,
            };
            let constants = Constants::new()
                .set(shaders::constant::DETAIL, true)
                .set(shaders::constant::TILED, true)
                .set(shaders::constant::LISTS, true)
                .set(shaders::constant::THREADS, 128)
                .set(shaders::constant::WORKGROUP, 128);
            let of_bins = bins.bind(context, "bins").expect("a set");
            let sets = [maps.scene(), &of_bins, &of_detail];
            let choose = Kernel::compute(context, &shaders::detail::CHOOSE, &sets, &constants).expect("made");
            let push = ChoosePush { tile_count: TILES as u32, across: 8, block_count };
            context.submit(|c| c.pass("choose", |pass| pass.dispatch(&choose, &push, [1; 3]))).expect("submitted");
            let words: Vec<u32> = slots.read(TILES * 64).expect("read");
            let sides: Vec<u32> = words.iter().step_by(64).map(|word| word >> 28).collect();
            let place = |slot: usize| {
                let is_block = (slot % 64) < sides[slot / 64].pow(2) as usize;
                (words[slot] & 0xFFF_FFFF).checked_sub(1).filter(|_| is_block)
            };
            let blocks: Vec<u32> =
                (0..TILES * 64).filter(|slot| place(*slot).is_some()).map(|slot| slot as u32).collect();
            let list: Vec<u32> = listed.read(blocks.len() + 1).expect("read");
            assert!(blocks.len() <= block_count as usize && blocks.len() > 40, "{} of {block_count}", blocks.len());
            assert_eq!(list, [&[blocks.len() as u32], &blocks[..]].concat());

            // Gives each slot up to 4,095 casters, and some slots none.
            let mut count = |slot| place(slot).map_or(0, |_| (random.bits() >> 20) >> (random.bits() % 13));
            let counts: Vec<u32> = (0..TILES * 64).map(&mut count).collect();
            let push = BinPush { caster_count: 1, capacity: 1 << 30, room, mark: 1, map_count: 1 };
            let [fullest, any] = [true, false].map(|fullest_first| {
                let [parts, cursors] = [4 * (TILES * 64 + 64), TILES * 64].map(|n| buffer("words", &vec![0; n]));
                let (counts, totals) = (buffer("counts", &counts), totals());
                let of_bins = set::Bins { counts: &counts, parts: &parts, cursors: &cursors, totals: &totals, ..bins };
                let of_bins = of_bins.bind(context, "bins").expect("a set");
                let (shader, groups) = if fullest_first {
                    (&shaders::bins::PLACE_FULLEST_LISTED_1, 1)
                } else {
                    (&shaders::bins::PLACE, TILES as u32)
                };
                let sets = [maps.scene(), &of_bins, &of_detail];
                let sets = if fullest_first { &sets[..] } else { &sets[..2] };
                let kernel = Kernel::compute(context, shader, sets, &constants).expect("made");
                context.submit(|c| c.pass("place", |p| p.dispatch(&kernel, &push, [groups, 1, 1]))).expect("submitted");
                let found: BinTotals = totals.read(1).expect("read")[0];
                let parts: Vec<[u32; 4]> = parts.read(found.parts as usize).expect("read");
                (found, parts, cursors.read::<u32>(TILES * 64).expect("read"))
            });
            let mut least = u32::MAX;
            for [.., count] in &fullest.1 {
                assert!(4 * u64::from(*count) <= 5 * u64::from(least), "{count} behind {least}");
                least = least.min(*count);
            }
            let [known, other] = [&fullest, &any].map(|(totals, ..)| {
                (totals.all_entries(), totals.tiles_used, totals.fullest, totals.parts, totals.groups_y)
            });
            assert_eq!(known, other);
            for (_, mut parts, cursors) in [fullest, any] {
                parts.sort_unstable();
                let read = |slot: &u32| [*slot, counts[*slot as usize].min(if room > 0 { room } else { u32::MAX })];
                assert!(parts.iter().map(|part| [part[0], part[3]]).eq(blocks.iter().map(read)));
                // Without a fixed capacity per block, the blocks' entries are packed back to back, in any order.
                parts.sort_unstable_by_key(|part| (part[2], part[3]));
                let mut end = 0;
                for [slot, _, first, count] in parts {
                    let own = place(slot as usize).map(|place| place * room);
                    assert!(if room > 0 { own == Some(first) } else { count == 0 || first == end }, "{slot}: {first}");
                    assert!(room > 0 || count == 0 || cursors[slot as usize] == first, "{slot}: {first}");
                    end = if count > 0 { first + count } else { end };
                }
            }
        }
    });
}

/// The total of all tiles' entries is counted in 64 bits. A total past 32 bits is an error, and no tile is assigned a place that does not
/// exist.
#[test]
fn entries_are_counted_past_32_bits() {
    gpu_test("entries_are_counted_past_32_bits", |context| {
        let world = World::new(context, &scenes::random()).expect("room for the scene");
        let maps = Maps::new(context, &world, 64, OpaqueMaps::SHARED).expect("room for the maps");
        let every_entry =
            Use { entries: Entries::Sorted, skip: false, reach: 0, parts: [1, 0], area: false, blocks: None };
        let mut random = Random::new(52);
        let few: Vec<u32> = (0..64).map(|_| random.bits() >> 20).collect();
        let many: Vec<u32> = (0..64).map(|_| random.bits()).collect();
        for (counts, words) in
            [(vec![1 << 26; 64], 1), (vec![u32::MAX; 64], 63), (few, 0), (many.clone(), 20), (many, 1)]
        {
            let sum: u64 = counts.iter().copied().map(u64::from).sum();
            let buffer = |name, words: &[u32]| Buffer::with_data(context, name, words).expect("room");
            let totals = buffer("totals", &[0; size_of::<BinTotals>() / 4]);
            let [counts, parts] = [buffer("counts", &counts), buffer("parts", &[0; 4 * 128])];
            let [cursors, entries, met, horizon] =
                ["cursors", "entries", "met", "horizon"].map(|n| buffer(n, &[0; 64]));
            // Without detail, slots are not read.
            let set = set::Bins {
                counts: &counts,
                parts: &parts,
                cursors: &cursors,
                totals: &totals,
                entries: &entries,
                met: &met,
                horizon: &horizon,
                slots: &horizon,
            };
            let set = set.bind(context, "bins").expect("a set");
            let place = if words > 1 { &shaders::bins::PLACE } else { &shaders::bins::PLACE_FULLEST_LISTED_0 };
            let constants =
                Constants::new().set(shaders::constant::THREADS, 128).set(shaders::constant::WORKGROUP, 128);
            let kernel = Kernel::compute(context, place, &[maps.scene(), &set], &constants).expect("made");
            let push = BinPush { caster_count: 1, capacity: 100, room: 0, mark: 1, map_count: 1 };
            context.submit(|c| c.pass("place", |pass| pass.dispatch(&kernel, &push, [1, 1, 1]))).expect("submitted");
            let found: BinTotals = totals.read(1).expect("read")[0];
            assert_eq!(found.all_entries(), sum);
            assert!(u64::from(found.entries_high) >= words, "{found:?}");
            // A count of more than 32 bits exceeds what any device can bind: an error every time, not a request for more room.
            let mut bins = Bins::new(context, &world, &maps, every_entry).expect("room for the bins");
            for again in [true, false] {
                match bins.make_room(found) {
                    Ok(grew) => assert!(words == 0 && grew == again, "{found:?}"),
                    Err(Error::Gpu { name, cause, .. }) => {
                        assert!(words > 0 && name == "bins.entries", "{name}, {found:?}");
                        assert!(
                            cause.to_string().starts_with(&format!("{} bytes", 8 * sum)),
                            "{cause} of {sum} entries"
                        );
                    }
                    Err(error) => panic!("{error}"),
                }
            }
            for part in parts.read::<[u32; 4]>(64).expect("read") {
                assert!(u64::from(part[2].min(100)) + u64::from(part[3]) <= 100, "{part:?} reads past the entries");
            }
        }
    });
}

/// More than a million opaque casters over one texel: the bound on the sum of their optical depths overflows 32 bits, and so would the
/// fixed-point sum itself if its unit were derived from the wrapped bound.
#[test]
fn a_million_opaque_casters_are_dark() {
    let name = "a_million_opaque_casters_are_dark";
    if is_left_out(name) {
        return;
    }
    gpu_test(name, |context| {
        if context.features().driver.contains("Mesa 22.") {
            return skipped(name, "loops end after 65,536 rounds on this driver (docs/reference/drivers.md)");
        }
        // Each caster adds 4,097 to the bound: slightly more than 2³² in total.
        let count = (1u64 << 32).div_ceil(4097) as usize + 2;
        let sphere = Particle { position: [0.0; 3], radius: 0.75, extinction: 1e6 };
        let mut scene = scenes::directional("opaque", [0.0, 0.0, -1.0], vec![sphere; count]);
        scene.particles.push(Particle { position: [0.0, 0.0, 3.0], radius: 0.75, extinction: 0.0 });
        for text in ["beer-shadow-map:path=binned,size=1", "psm:path=fused,size=8,slices=16"] {
            let answers = ask(context, built(context, &scene, text).as_ref(), 0, &[[0.0, 0.0, 3.0], [0.0, 0.0, -1.5]]);
            assert_eq!(answers, [1.0, 0.0], "{text}");
        }
    });
}

/// No dimension has more workgroups than every device supports; all that are needed are dispatched, and few more.
#[test]
fn workgroups_are_what_every_device_takes() {
    for count in [0, 1, 64, 65_534, 65_535, 65_536, 65_537, 1 << 20, 65_535 * 65_535, u64::from(u32::MAX) * 16 / 64] {
        let [x, y] = groups(count);
        assert!(x <= 65_535 && y <= 65_535, "{count}: {x} × {y}");
        let all = u64::from(x) * u64::from(y);
        assert!((count..=count + u64::from(y)).contains(&all), "{count}: {x} × {y}");
    }
    // Up to 16 threads per caster, 64 per workgroup: more workgroups than fit in one dimension.
    assert!(groups(262_141 * 16 / 64 + 1)[1] > 1);
}

/// From the second build on, every tile has the same capacity and entries are not counted beforehand. If a tile exceeds that capacity,
/// entries are counted again. Either way the tiles hold the same casters.
#[test]
fn tiles_have_the_same_room() {
    gpu_test("tiles_have_the_same_room", |context| {
        let every_entry =
            Use { entries: Entries::Sorted, skip: false, reach: 0, parts: [1, 0], area: false, blocks: None };
        let world = World::new(context, &scenes::random()).expect("room for the scene");
        let mut maps = Maps::new(context, &world, 64, OpaqueMaps::SHARED).expect("room for the maps");
        let mut bins = Bins::new(context, &world, &maps, every_entry).expect("room for the bins");
        let mut build = |bins: &mut Bins| {
            let mut frame = 0;
            let passes = context.submit(|commands| {
                frame = commands.frame();
                maps.record(commands, &world).expect("its lights");
                bins.record(commands, &world);
            });
            let counted = passes.expect("submitted").iter().any(|pass| pass.name == "bins.count");
            (counted, bins.settle(frame).expect("room"), bins.counts.read::<u32>(64).expect("read"))
        };
        // Passes have names only if they are timed.
        let named = context.features().timestamp_valid_bits > 0;
        let (counted, again, counts) = build(&mut bins);
        assert!(counted == named && again, "the first build counts");
        let fullest = *counts.iter().max().expect("tiles");
        assert!(fullest > 1, "{counts:?}");
        let culled = bins.counters().expect("counted")["culled_casters"];
        assert_eq!(build(&mut bins), (false, false, counts.clone()));
        assert_eq!(bins.counters().expect("counted")["culled_casters"], culled, "marks of two builds");
        let roomy = bins.bytes_transient();
        assert!(roomy > 64 * 8 * u64::from(fullest), "{roomy} bytes for {fullest} in each tile");
        // First more than a tile has room for, then more than any tile may have.
        let totals = |fullest| BinTotals { fullest, entries: fullest, ..BinTotals::default() };
        assert!(bins.make_room(totals(2 * fullest + 64)).expect("room"));
        assert!(bins.bytes_transient() > roomy);
        assert_eq!(build(&mut bins), (false, false, counts.clone()));
        assert!(bins.make_room(totals(1 << 16)).expect("room"));
        assert_eq!(build(&mut bins), (named, true, counts));
    });
}
