"""Runs the shards of a sweep on the workers of a Dask scheduler.

python3 on_dask.py SCHEDULER COUNT SCRIPT: SCRIPT NUMBER runs a shard. A shard whose worker dies is run again by another.
"""

import subprocess
import sys

from distributed import Client, as_completed


def shard(script, number):
    done = subprocess.run(["sh", script, str(number)], capture_output=True, text=True)
    return number, done.returncode, done.stderr[-2000:]


def main():
    scheduler, count, script = sys.argv[1], int(sys.argv[2]), sys.argv[3]
    failed = 0
    with Client(scheduler, timeout=30) as client:
        # A shard goes on where it was, so that running it again is always right.
        futures = client.map(shard, [script] * count, range(count), retries=3, pure=False)
        for future in as_completed(futures):
            if future.status != "finished":
                failed += 1
                print(f"a shard failed: {future.exception()}", file=sys.stderr)
                continue
            number, status, said = future.result()
            if status != 0:
                failed += 1
                print(f"shard {number} ended with status {status}: {said}", file=sys.stderr)
    sys.exit(1 if failed else 0)


if __name__ == "__main__":
    main()
