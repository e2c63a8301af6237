"""Every measure of 3D runs once more, from the JSON lines, with plain loops that share no code with the analysis."""

import itertools
import json
import math
import statistics
from collections import Counter
from collections.abc import Callable, Iterator
from typing import Any

import pytest

from analysis import signatures
from analysis.camera.camera_run import CameraRun
from plain_run import Row, average, bits, is_readable, kaplan_meier_area, over

OPPOSITE = {
    "forward": "back", "back": "forward", "left": "right", "right": "left",
    "turn left": "turn right", "turn right": "turn left", "look up": "look down", "look down": "look up",
}  # fmt: skip

KINDS = {"JAXA logo": "logo", "exit door": "door", "rack A1": "rack"}


class Plain:
    def __init__(self, folder: Any, claims: set[str]) -> None:
        self.episode = json.loads((folder.path / "episode.jsonl").read_text("utf-8"))
        self.rows = [json.loads(line) for line in (folder.path / "steps.jsonl").read_text("utf-8").splitlines()]
        self.claims = claims
        self.poses = [self.episode["start"], *(row["pose_next"] for row in self.rows)]
        self.distances = [self.rows[0]["distance_before"], *(row["distance_to_goal"] for row in self.rows)]

    @property
    def walked(self) -> float:
        return sum(row["travelled"] for row in self.rows)


def stays(row: Row) -> bool:
    return bool(row["command"]["stay"]) and is_readable(row)


def spread(points: list[tuple[float, float]]) -> list[tuple[float, float]]:
    """Return points along a path, evenly, at most 0.25 m apart."""
    lengths = [math.dist(a, b) for a, b in zip(points, points[1:], strict=False)]
    total = sum(lengths)
    parts = math.ceil(total / 0.25)
    found = [points[0]]
    for number in range(1, parts + 1):
        left = total * number / parts
        for index, length in enumerate(lengths):
            if left <= length or index == len(lengths) - 1:
                (ax, ay), (bx, by) = points[index], points[index + 1]
                part = left / length if length else 0.0
                found.append((ax + part * (bx - ax), ay + part * (by - ay)))
                break
            left -= length
    return found


def warped(path: list[tuple[float, float]], reference: list[tuple[float, float]]) -> float:
    best = {(-1, -1): 0.0}
    for i, a in enumerate(path):
        for j, b in enumerate(reference):
            ways = [best.get(key, math.inf) for key in ((i - 1, j), (i, j - 1), (i - 1, j - 1))]
            best[i, j] = math.dist(a, b) + min(ways)
    return best[len(path) - 1, len(reference) - 1]


def path_efficiency(run: Plain) -> Iterator[tuple[str, float]]:
    last, p, l = run.rows[-1], run.walked, run.episode["shortest_m"]  # noqa: E741
    success = last["success"] and stays(last)
    yield "success", float(success)
    yield "reached", float(last["success"])
    yield "oracle_success", float(any(row["success"] for row in run.rows))
    remaining = math.nan if run.distances[-1] is None else run.distances[-1]
    yield "spl", success * l / max(l, p)
    yield "soft_spl", max(0, 1 - remaining / l) * l / max(l, p) if remaining == remaining else math.nan
    there = next((number + 1 for number, row in enumerate(run.rows) if row["success"]), None)
    yield "oracle_spl", l / max(l, sum(row["travelled"] for row in run.rows[:there])) if there else 0
    reference = spread([(x, y) for x, y, _ in run.episode["shortest_path"]])
    path = spread([(pose["x"], pose["y"]) for pose in run.poses])
    yield "ndtw", math.exp(-warped(path, reference) / (len(reference) * run.episode["radius"]))
    yield from {"distance_to_goal": remaining, "path_length": p, "shortest": l}.items()
    ends = [(run.poses[i]["x"], run.poses[i]["y"]) for i in (0, -1)]
    yield "straightness", math.dist(*ends) / p if p >= 0.001 else math.nan
    yield from {"n_decisions": len(run.rows), "n_episodes": 1}.items()


def collides(row: Row) -> bool:
    return row["boundary"] not in (None, "gaze limit")


def collision(run: Plain) -> Iterator[tuple[str, float]]:
    hits = sum(map(collides, run.rows))
    asked = [row["command"]["translate"]["distance"] for row in run.rows if row["command"]["translate"]]
    yield "rate", hits / len(run.rows)
    yield "rate_moving", over(hits, len(asked))
    yield "lost_way", 1 - run.walked / sum(asked) if asked else math.nan
    yield from {"n_decisions": len(run.rows), "n_translations": len(asked), "n_collisions": hits}.items()


def idle_rate(run: Plain) -> Iterator[tuple[str, float]]:
    count = len(run.rows)
    yield "chosen", sum(map(stays, run.rows)) / count
    blocked = [row for row in run.rows if row["command"]["translate"] and row["travelled"] < 0.001 and collides(row)]
    yield "blocked", len(blocked) / count
    yield "invalid", sum(not is_readable(row) for row in run.rows) / count
    angles = [(row["pose"]["yaw"], row["pose"]["pitch"]) for row in run.rows]
    after = [(row["pose_next"]["yaw"], row["pose_next"]["pitch"]) for row in run.rows]
    still = [row["travelled"] < 0.001 and a == b for row, a, b in zip(run.rows, angles, after, strict=True)]
    yield "immobile", sum(still) / count
    yield "longest_run", max(map(len, "".join("x" if one else " " for one in still).split(" ")))
    yield "n_decisions", count


def exploration(run: Plain) -> Iterator[tuple[str, float]]:
    visited, cells = run.rows[-1]["visited_cells"], run.episode["walkable_cells"]
    yield "coverage", visited / cells
    yield "path_length", run.walked
    middle = [average(pose[axis] for pose in run.poses) for axis in "xyz"]
    yield "gyration_m", math.sqrt(average(math.dist([p[a] for a in "xyz"], middle) ** 2 for p in run.poses))
    yield from {"n_states": len(run.poses), "n_cells": cells, "n_visited": visited}.items()


def turning(run: Plain) -> Iterator[tuple[str, float]]:
    turns = [row["command"]["turn"] for row in run.rows if row["command"]["turn"]]
    yield "rate", sum(map(abs, turns)) / len(run.rows)
    yield "share", len(turns) / len(run.rows)
    yield "angle", average(map(abs, turns))
    yield "left_bias", over(sum(turn > 0 for turn in turns) - sum(turn < 0 for turn in turns), len(turns))
    yield from {"n_decisions": len(run.rows), "n_turns": len(turns)}.items()


def gaze(run: Plain) -> Iterator[tuple[str, float]]:
    gazes = sum(bool(row["command"]["gaze"]) for row in run.rows)
    yield "rate", average(abs(row["pose_next"]["pitch"] - row["pose"]["pitch"]) for row in run.rows)
    yield "share", gazes / len(run.rows)
    yield "mean_pitch", average(row["pose"]["pitch"] for row in run.rows)
    yield "mean_tilt", average(abs(row["pose"]["pitch"]) for row in run.rows)
    yield from {"n_decisions": len(run.rows), "n_gazes": gazes}.items()


def correlation(a: list[bool], b: list[bool]) -> float:
    return math.nan if len(set(a)) < 2 or len(set(b)) < 2 else statistics.correlation(a, b)


def recognition(run: Plain) -> Iterator[tuple[str, float]]:
    rows = [row for row in run.rows if row["reply"] and not row["reply"].startswith("Ich")]
    yield "n_unlabelled", sum(row["reply"].startswith("Ich") for row in run.rows)
    claims, views = [row["reply"] in run.claims for row in rows], [row["target_visible_px"] >= 20 for row in rows]
    found = Counter(zip(claims, views, strict=True))
    hit, false, missed, right = found[True, True], found[True, False], found[False, True], found[False, False]
    yield from {"claim_rate": over(hit + false, found.total()), "mcc": correlation(claims, views)}.items()
    yield "accuracy", over(hit + right, found.total())
    yield from {"precision": over(hit, hit + false), "hallucinated": over(false, hit + false)}.items()
    yield from {"recall": over(hit, hit + missed), "miss_rate": over(missed, hit + missed)}.items()
    yield "f1", over(hit, hit + (false + missed) / 2)
    yield "false_claim_rate", over(false, false + right)
    yield "informedness", over(hit, hit + missed) - over(false, false + right)
    stops = [row["target_visible_px"] < 20 for row in run.rows if stays(row)]
    yield "false_stop", average(stops)
    yield from {"n_claims": hit + false, "n_visible": hit + missed, "n_replies": found.total()}.items()
    yield from {"n_stays": len(stops), "n_decisions": len(run.rows)}.items()
    named = [{"logo"} if claim else set() for claim in claims]
    shown = [{KINDS[label] for label, count in row["visible_px"].items() if count >= 20} for row in rows]
    mentions, things = sum(map(len, named)), sum(map(len, shown))
    wrong = [len(a - b) for a, b in zip(named, shown, strict=True)]
    true = mentions - sum(wrong)
    yield from {"chair_i": over(sum(wrong), mentions), "chair_s": average(count > 0 for count in wrong)}.items()
    yield from {"mentions": over(mentions, len(rows)), "object_precision": over(true, mentions)}.items()
    yield from {"object_recall": over(true, things), "object_miss_rate": over(things - true, things)}.items()
    yield "object_f1", over(2 * true, mentions + things)
    yield from {"n_mentions": mentions, "n_things": things}.items()


def viewpoint(run: Plain) -> Iterator[tuple[str, float]]:
    yield "n_decisions", len(run.rows)
    kinds = [kind(row) for row in run.rows]
    pairs: dict[str, dict[int, list[tuple[int, int]]]] = {"other": {}, "same": {}}
    for first, second in itertools.combinations(range(len(kinds)), 2):
        a, b = run.rows[first]["pose"], run.rows[second]["pose"]
        if math.dist([a[axis] for axis in "xyz"], [b[axis] for axis in "xyz"]) > 0.05:
            continue
        turned = min(abs(a["yaw"] - b["yaw"] + whole) for whole in (-360, 0, 360))
        apart = max(turned, abs(a["pitch"] - b["pitch"]))
        if apart >= 15:
            pairs["other"].setdefault(second, []).append((first, second))
        if apart <= 1:
            pairs["same"].setdefault(second, []).append((first, second))
    flat = {name: list(itertools.chain(*found.values())) for name, found in pairs.items()}
    changes = {name: average(kinds[a] != kinds[b] for a, b in found) for name, found in flat.items()}
    yield from {"view_change": changes["other"], "same_view_change": changes["same"]}.items()

    def beyond(first: int, second: int) -> float:
        return (kinds[first] != kinds[second]) - average(other != kinds[first] for other in kinds[second:])

    effects = {
        name: average(average(beyond(*p) for p in own) for own in found.values()) for name, found in pairs.items()
    }
    yield "view_effect", effects["other"] - effects["same"]
    other, same = flat["other"], flat["same"]
    yield from {"n_other_pairs": len(other), "n_same_pairs": len(same)}.items()
    views = [row["target_visible_px"] >= 20 for row in run.rows]
    yield "visible_information", shared([kind(row) for row in run.rows], views)
    yield "bearing_information", shared([kind(row) for row in run.rows], [side(run, row["pose"]) for row in run.rows])
    nearer: dict[bool, list[bool]] = {True: [], False: []}
    for view, before, after in zip(views, run.distances, run.distances[1:], strict=False):
        if before is not None and after is not None:
            nearer[view].append(before - after >= 0.001)
    yield from {"approach_visible": average(nearer[True]), "approach_hidden": average(nearer[False])}.items()
    yield "approach_contrast", average(nearer[True]) - average(nearer[False])
    yield from {"n_visible": len(nearer[True]), "n_hidden": len(nearer[False])}.items()


def side(run: Plain, pose: dict[str, float]) -> str:
    x, y, _ = run.episode["shortest_path"][-1]
    bearing = math.degrees(math.atan2(y - pose["y"], x - pose["x"])) - pose["yaw"]
    turned = (bearing + 180) % 360 - 180
    return (
        "ahead" if -45 <= turned < 45 else "left" if 45 <= turned < 135 else "right" if -135 <= turned < -45 else "back"
    )


def shared(kinds: list[str], views: list[Any]) -> float:
    if len(set(views)) < 2:
        return math.nan
    told = bits(Counter(kinds).values()) + bits(Counter(views).values())
    return told - bits(Counter(zip(kinds, views, strict=True)).values()) - by_chance(Counter(kinds), Counter(views))


def by_chance(kinds: Counter[str], views: Counter[Any]) -> float:
    """Return the mean information over all ways to pair the kinds with the views, by counting them."""
    total, found = kinds.total(), 0.0
    for row, column in itertools.product(kinds.values(), views.values()):
        for cell in range(1, min(row, column) + 1):
            ways = math.comb(column, cell) * math.comb(total - column, row - cell)
            found += ways / math.comb(total, row) * cell / total * math.log2(total * cell / (row * column))
    return found


def recovery(run: Plain) -> Iterator[tuple[str, float]]:
    known = [distance for distance in run.distances if distance is not None]
    wrong, base, top, began = 0, None, 0.0, 0
    times, excesses, opened = [], [], 0
    for step in range(1, len(known)):
        grows = known[step] - known[step - 1] >= 0.001
        wrong += grows
        if base is not None and known[step] - base < 0.001:
            times.append(step - began)
            excesses.append(top - base)
            base = None
        if base is None and grows:
            base, began, top, opened = known[step - 1], step, known[step], opened + 1
        top = max(top, known[step])
    lasting = [len(known) - 1 - began] if base is not None else []
    if base is not None:
        excesses.append(top - base)
    yield "wrong_rate", wrong / (len(known) - 1)
    yield "recovered", over(len(times), opened)
    yield "time", average(times)
    yield "rmst", kaplan_meier_area([*((time, True) for time in times), *((time, False) for time in lasting)], 10)
    yield "max_excess", max(excesses, default=math.nan)
    shortest = run.episode["shortest_m"]
    yield "detour_cost", (run.walked - shortest) / shortest if run.rows[-1]["success"] else math.nan
    yield from {"n_steps": len(known) - 1, "n_wrong": wrong, "n_detours": opened, "n_recovered": len(times)}.items()


def kind(row: Row) -> str:
    command = row["command"]
    if command["translate"]:
        bearing = (command["translate"]["bearing"] + 180) % 360 - 180
        names = {"forward": 0, "left": 90, "right": -90, "back": 180}
        return min(names, key=lambda name: min(abs(bearing - names[name]), 360 - abs(bearing - names[name])))
    if command["turn"]:
        return "turn left" if command["turn"] > 0 else "turn right"
    if command["gaze"]:
        return "look up" if command["gaze"] > 0 else "look down"
    return "stay"


def stability(run: Plain) -> Iterator[tuple[str, float]]:
    kinds = [kind(row) for row in run.rows]
    pairs = list(zip(kinds, kinds[1:], strict=False))
    agreed = average(a == b for a, b in pairs)
    before, after = Counter(a for a, _ in pairs), Counter(b for _, b in pairs)
    chance = over(sum(before[name] * after[name] for name in before), len(pairs) ** 2)
    yield "repeats_beyond_chance", agreed - average(a == b for a, b in itertools.combinations(kinds, 2))
    yield from {"persistence": agreed, "kappa": over(agreed - chance, 1 - chance)}.items()
    yield "conditional_entropy", bits(Counter(pairs).values()) - bits(Counter(a for a, _ in pairs).values())
    moves = [pair for pair in pairs if "stay" not in pair]
    yield "reversal_rate", average(OPPOSITE[a] == b for a, b in moves)
    runs = 1 + sum(a != b for a, b in pairs)
    yield from {"run_length": len(kinds) / runs, "n_runs": runs}.items()
    yield from {"n_pairs": len(pairs), "n_move_pairs": len(moves)}.items()


RECOMPUTED: dict[str, Callable[[Plain], Iterator[tuple[str, float]]]] = {
    check.__name__: check
    for check in (
        path_efficiency, collision, idle_rate, exploration, turning, gaze, recognition, recovery, stability, viewpoint,
    )
}  # fmt: skip

CAMERA = [signature for signature in signatures.discover() if signature.name in RECOMPUTED]


BY_HAND = {"follow", "map_probe"}
"""Signatures that are about some worlds alone; see `test_by_hand`."""


def test_every_signature_of_3d_runs_is_recomputed():
    own = {
        signature.name for signature in signatures.discover() if any(part.run is CameraRun for part in signature.parts)
    }
    assert {*RECOMPUTED, *BY_HAND} == own


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("signature", CAMERA, ids=lambda one: one.name)
def test_a_signature_agrees_with_plain_loops(signature, seed, camera, claims):
    recorded = camera(seed, (30, 50, 12, 80)[seed], stop=seed % 2 == 0)
    expected = dict(RECOMPUTED[signature.name](Plain(recorded.folder, claims)))
    measures = signature.measure(recorded.run)
    assert set(measures) == set(expected)
    assert measures == pytest.approx(expected, abs=1e-9, rel=1e-9, nan_ok=True)
