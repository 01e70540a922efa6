#!/usr/bin/env python3
"""The folded formula, written again from docs/proofs.md alone.

Reads an expanded machine file (`srp machine expand`), a list of edges and one of operations (docs/graphs.md), and a
formula that `srp map --proof` has written, and says whether the formula is the one that this program makes of
machine and graph: the same clauses under the names of the variables.

    fold.py MACHINE.xml NAME.edges NAME.ops FORMULA.cnf GRAPHS.md

Words only: no live-ins, no live-outs, no predicates. It shares no code with the scheduler.
"""

import re
import sys
import xml.etree.ElementTree as xml
from collections import defaultdict

WORD = 32


class Machine:
    def __init__(self, path):
        root = xml.parse(path).getroot()
        array = root.find("array")
        self.resources = {r.get("name"): int(r.get("count")) for r in root.findall("resource")}
        self.units, self.how, self.links = [], {}, []
        for fu in array.findall("fu"):
            if int(fu.get("width")) < WORD:
                sys.exit("units of words only")
            name = fu.get("name")
            self.units.append(name)
            self.how[name] = {
                op.get("class"): (int(op.get("latency")), int(op.get("interval")), op.get("uses").split())
                for op in fu.findall("op")
            }
        for link in array.findall("link"):
            self.links.append((link.get("from"), link.get("to"), int(link.get("delay")), int(link.get("width"))))
        self.files = {f.get("name"): f for f in array.findall("file") if int(f.get("width")) >= WORD}
        if any(f.get("kind") == "central" for f in self.files.values()):
            sys.exit("machines without central files only")

    def reads(self, unit):
        """Places a unit reads, each with the cycles on the way."""
        yield ("out", f"{unit}_out"), 0
        for source, to, delay, width in self.links:
            if to == unit and width >= WORD:
                yield ("out", f"{source}_out"), delay
        for name, file in self.files.items():
            if unit in file.get("readers").split():
                yield ("held", name), 0

    def writes(self, name):
        """Ways into a file: the name of the way, the unit, and the cycles from its output; None for its result."""
        writers = self.files[name].get("writers").split()
        for unit in self.units:
            if unit in writers:
                yield unit, unit, None
        if self.files[name].get("from-links") == "true":
            for number, (source, to, delay, width) in enumerate(self.links):
                for _ in filter(lambda w: w == to, writers):
                    if width >= WORD:
                        yield f"link{number}", f"{source}_out", delay + 1


def read_graph(edges, ops, table):
    """Classes of nodes n0, n1, … in the order of the list of operations, and the edges between them."""
    classes = {}
    for line in open(table):
        found = re.match(r"\| `(\w+)` \| `(\w+)` \| (.*) \|", line)
        if found:
            for name in [found[1]] + re.findall(r"`([^`]+)`", found[3]):
                classes[name] = found[2]
    lines = lambda path: filter(None, (line.split("#")[0].split() for line in open(path)))
    number, nodes = {}, {}
    for name, op in lines(ops):
        number[name] = f"n{len(number)}"
        nodes[number[name]] = classes[op.lower().split(".")[0]]
    return nodes, [(number[w[0]], number[w[1]], int(w[2]) if len(w) > 2 else 0) for w in lines(edges)]


class Clauses:
    """Clauses over names: a literal is a name and whether it holds."""

    def __init__(self, rank):
        self.all, self.rank, self.names = set(), rank, set()

    def add(self, *literals):
        self.names.update(name for name, _ in literals)
        self.all.add(frozenset(literals))

    def implies(self, cause, effects):
        self.add((cause, False), *((name, True) for name in effects))

    def at_most(self, most, names, label):
        names = sorted(names, key=lambda name: self.rank[name])
        if len(names) <= most:
            return
        if most == 0:
            for name in names:
                self.add((name, False))
        elif most == 1 and len(names) <= 5:
            for i, name in enumerate(names):
                for other in names[:i]:
                    self.add((name, False), (other, False))
        else:
            before = []
            for i, name in enumerate(names):
                if most == 1 and i + 1 == len(names):
                    self.add((name, False), (before[0], False))
                    return
                now = [f"{label} {i}.{k}" for k in range(most)]
                self.implies(name, now[:1])
                for k, counted in enumerate(before):
                    self.implies(counted, [now[k]])
                    more = [(now[k + 1], True)] if k + 1 < most else []
                    self.add((name, False), (counted, False), *more)
                before = now


def windows(nodes, edges, wait, ii):
    """Least and most cycles between neighbours of one recurrence, by longest paths between all nodes."""
    far = {(n, n): 0 for n in nodes}
    for source, to, distance in edges:
        if source != to:
            weight = wait[source] - ii * distance
            far[source, to] = max(weight, far.get((source, to), weight))
    for k in nodes:
        for a in nodes:
            if (a, k) in far:
                for b in nodes:
                    if (k, b) in far:
                        over = far[a, k] + far[k, b]
                        far[a, b] = max(over, far.get((a, b), over))
    for source, to, _ in edges:
        if source != to and (to, source) in far:
            yield source, to, far[source, to], -far[to, source]
            yield to, source, far[to, source], -far[source, to]


def formula(machine, nodes, edges, ii, laps, depth, rank):
    clauses = Clauses(rank)
    round_ = ii * laps
    runs = {n: [u for u in machine.units if c in machine.how[u]] for n, c in nodes.items()}
    timing = lambda n, u: machine.how[u][nodes[n]]
    moves = {u: machine.how[u]["alu"] for u in machine.units if "alu" in machine.how[u]}
    taken = sum(min(timing(n, u)[1] for u in runs[n]) for n in nodes)
    least = min((m[1] for m in moves.values()), default=None)
    spare = max(0, len(machine.units) * ii - taken) // least if least else 0
    depth = min(depth, spare)
    levels = list(range(depth + 1)) + (["deep"] if spare > depth else [])
    budgets = defaultdict(set)

    def issue(unit, time, how, name):
        for k in range(how[1]):
            budgets[f"issue {unit} {(time + k) % ii}", 1].add(name)
            for resource in how[2]:
                budgets[f"shared {resource} {(time + k) % ii}", machine.resources[resource]].add(name)

    ends = defaultdict(int)
    for source, to, _ in edges:
        ends[source] += 1
        ends[to] += 1
    anchor = max(nodes, key=lambda n: ends[n])
    starts = lambda n, t: [f"start {n} {u} {t}" for u in runs[n] if timing(n, u)[1] <= ii]
    for n in nodes:
        for t in range(round_):
            clauses.implies(f"at {n} {t}", starts(n, t))
            for u in runs[n]:
                if timing(n, u)[1] <= ii:
                    clauses.implies(f"start {n} {u} {t}", [f"at {n} {t}"])
                    clauses.implies(f"start {n} {u} {t}", [f"on {n} {u}"])
                    issue(u, t, timing(n, u), f"start {n} {u} {t}")
                    if n == anchor and t:
                        clauses.add((f"start {n} {u} {t}", False))
        clauses.add(*((f"at {n} {t}", True) for t in range(round_)))
        clauses.at_most(1, [f"at {n} {t}" for t in range(round_)], f"one-cycle {n}")
        clauses.at_most(1, [f"on {n} {u}" for u in runs[n] if timing(n, u)[1] <= ii], f"one-unit {n}")
    wait = {n: min(timing(n, u)[0] for u in runs[n]) for n in nodes}
    for a, b, low, high in windows(nodes, edges, wait, ii):
        if high - low + 1 < round_:
            for t in range(round_):
                clauses.implies(f"at {a} {t}", [f"at {b} {(t + by) % round_}" for by in range(low, high + 1)])
    for v in nodes:
        uses = [e for e in edges if e[0] == v]
        if not uses:
            if nodes[v] not in ("store", "cstore"):
                for u in runs[v]:
                    for t in range(round_):
                        if timing(v, u)[1] <= ii:
                            slot = (t + timing(v, u)[0]) % ii
                            budgets[f"output {u}_out {slot}", 1].add(f"start {v} {u} {t}")
            continue
        value(machine, clauses, budgets, issue, v, levels, ii, round_, runs[v], timing, moves)
        for _, to, distance in uses:
            for u in runs[to]:
                if timing(to, u)[1] <= ii:
                    for t in range(round_):
                        reads = [
                            f"{kind} {v} {place} {level} {(t + ii * distance - delay) % round_}"
                            for (kind, place), delay in machine.reads(u)
                            for level in levels
                        ]
                        clauses.implies(f"start {to} {u} {t}", reads)
    for name, file in machine.files.items():
        for slot in range(ii):
            budgets[f"registers {name} {slot}", int(file.get("size"))] |= set()
    for (label, most), names in budgets.items():
        clauses.at_most(most, names, label)
    busy = {f"moves {u} {s}" for u in moves for s in range(ii)} & clauses.names
    clauses.at_most(spare, busy, "all-moves")
    return clauses


def value(machine, clauses, budgets, issue, v, levels, ii, round_, runs, timing, moves):
    """The copies of a value and their causes."""
    name = lambda kind, place, level, t: f"{kind} {v} {place} {level} {t % round_}"
    moving = [u for u in moves if moves[u][1] <= ii]

    def landing(unit, level, t):
        if level == 0:
            ok = unit in runs and timing(v, unit)[1] <= ii
            return [f"start {v} {unit} {(t - timing(v, unit)[0]) % round_}"] if ok else []
        return [name("move", unit, level, t - moves[unit][0])] if unit in moving else []

    for index, level in enumerate(levels):
        for t in range(round_):
            for u in machine.units:
                out = name("out", f"{u}_out", level, t)
                budgets[f"output {u}_out {t % ii}", 1].add(out)
                for lands in landing(u, level, t):
                    clauses.implies(lands, [out])
                if round_ > 1:
                    clauses.implies(out, [name("out", f"{u}_out", level, t - 1)] + landing(u, level, t))
                clauses.implies(out, [x for ago in range(ii) for x in landing(u, level, t - ago)])
            for f, file in machine.files.items():
                held, here = name("held", f, level, t), []
                for way, unit, cycles in machine.writes(f):
                    written = name(f"write.{way}", f, level, t)
                    here.append(written)
                    budgets[f"writes {f} {t % ii}", int(file.get("write-ports"))].add(written)
                    clauses.implies(written, [held])
                    cause = landing(unit, level, t) if cycles is None else [name("out", unit, level, t - cycles)]
                    clauses.implies(written, cause)
                if round_ > 1:
                    clauses.implies(held, [name("held", f, level, t - 1)] + here)
                ever = [name(f"write.{way}", f, level, x) for way, _, _ in machine.writes(f) for x in range(round_)]
                clauses.implies(held, ever)
                registers = budgets[f"registers {f} {t % ii}", int(file.get("size"))]
                if len(levels) == 1:
                    registers.add(held)
                else:
                    keep = f"keep {v} {f} {t}"
                    clauses.implies(held, [keep])
                    registers.add(keep)
            if index == 0:
                continue
            below = [levels[index - 1]] + ([level] if level == "deep" else [])
            for u in moving:
                move = name("move", u, level, t)
                issue(u, t, moves[u], move)
                clauses.implies(move, [f"moves {u} {t % ii}"])
                reads = [name(k, p, b, t - d) for b in below for (k, p), d in machine.reads(u)]
                clauses.implies(move, reads)
                if level == "deep" and index > 1:
                    before = [name("move", m, levels[index - 1], x) for m in moving for x in range(round_)]
                    clauses.implies(move, before)


def read_formula(path):
    """The facts in the comments, the number of each name, and the clauses, over names."""
    facts, names, clauses = {}, {}, []
    for line in open(path):
        words = line.split(" ", 3)
        if line.startswith("c var "):
            names[int(words[2])] = words[3].strip()
        elif line.startswith("c "):
            facts[words[1].rstrip(":")] = line.split(" ", 2)[2].strip()
        elif not line.startswith("p"):
            literals = [int(word) for word in line.split()[:-1]]
            clauses.append(frozenset((names[abs(l)], l > 0) for l in literals))
    return facts, {name: number for number, name in names.items()}, clauses


def main(machine, edges, ops, cnf, table):
    facts, rank, theirs = read_formula(cnf)
    found = re.match(r"folded, laps (\d+), depth (\d+)", facts["formula"])
    if not found:
        sys.exit(f"not a folded formula: {facts['formula']}")
    nodes, arcs = read_graph(edges, ops, table)
    laps, depth = int(found[1]), int(found[2])
    ours = formula(Machine(machine), nodes, arcs, int(facts["ii"]), laps, depth, rank).all
    tautology = lambda clause: any((name, not sign) in clause for name, sign in clause)
    ours = {clause for clause in ours if not tautology(clause)}
    theirs = {clause for clause in theirs if not tautology(clause)}
    for what, clauses in ("missing", ours - theirs), ("not ours", theirs - ours):
        for clause in sorted(map(sorted, clauses))[:5]:
            print(f"{what}: " + " or ".join(("" if sign else "not ") + name for name, sign in clause))
    if ours != theirs:
        sys.exit(f"{len(ours - theirs)} clauses are missing, {len(theirs - ours)} are not ours")
    print(f"the same: {len(ours)} clauses")


if __name__ == "__main__":
    main(*sys.argv[1:])
