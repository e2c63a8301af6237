"""What the interpreter reads from replies as vision-language models write them; distances in metres, angles in degrees.

Of the labelled replies, `dev`, `held` and `vlm` were written and labelled before the rule was read; `told` was written
with it, to hold what it does. `vlm` has 80 replies in the styles of five families of models; some are meant to be
unreadable. `held` was never looked at while the interpreter was written.

A reply is read `exactly` when translation, turn, gaze and staying are those of its label. Any other reading is
`invented` when it moves in a way that the label does not ask for (another kind, direction or amount), else `missed`.
"""

import json
import math
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from foundry.records import Outcome
from foundry.worlds.camera.language import Command, Translation
from foundry.worlds.camera.language.interpreter import interpret

FORWARD, BACK, LEFT, RIGHT, FORWARD_LEFT, FORWARD_RIGHT = 0, 180, 90, -90, 45, -45

MOVES: dict[tuple[int, float], list[str]] = {
    (RIGHT, 0.5): ["right 0.5 m", "sidestep right 50cm", "step right\n0.5 m", "move a bit to the right"],
    (RIGHT, 0.7): ["a step to the right"],
    (RIGHT, 1): ['The sign says "EXIT" with an arrow pointing right. Move right 1 m.',
        "move forward 2 m and to the right 1 m"],
    (RIGHT, 2): ["Distance: 2 m\nDirection: right"],
    (FORWARD_RIGHT, 2): ["move diagonally forward and to the right 2 m"],
    (-30, 2): ["move 2 m at 30 degrees to the right"],
    (FORWARD, 0): ["move forward 0 m"],
    (FORWARD, 0.5): ["前方に50センチ移動する", ".5 m forward", "move forward a little", "move forward 1/2 m",
        "move forward 500mm"],
    (FORWARD, 0.508): ["move forward 20 inches"],
    (FORWARD, 0.7): ["1歩前に進む"],
    (FORWARD, 0.75): ["three quarters of a metre forward"],
    (FORWARD, 1): ["go straight", "Keep moving forward 1 m.", "forward", "Don't turn; move forward 1 m.",
        "There is no need to turn right. Move forward 1 m.", "Move forward 5 m. Move forward 1 m.",
        "move closer to the logo by going forward 1 m", "move forward until 1 m in front of the wall",
        "move forward 1 m past the rack", "move forward 1 or 2 meters", "move forward 1.000 m", "move forward 1,000 mm",
        "Move forward 2 m/s", "Move forward at 0.5 m/s", "move forward 50%", "that's right, move forward 1 m",
        "What is left to do? Move forward 1 m.", "head forward", "advance", "I'll move forward 1 metre, maybe 2.",
        "right? I'm not sure. Move forward 1 m", "Let's move forward, keeping the wall on my left.", "move forward ١ m",
        "You're right. Move forward 1 m.", "Right, I will move forward 1 m.", "Right. Move forward 1 m.",
        "move forward 10^2 cm", "Move forward no more than 1 m.", "I would rather not turn left. Move forward 1 m.",
        "Move forward rather than turning left.", "Neither left nor right: move forward 1 m.",
        "Should I turn left? No. Move forward 1 m.", "move forward 1-2 m", "move forward 100 cm",
        "move forward 0.001 km", "move forward for 2 seconds", "move forward toward gate 4",
        "move forward to 1 m from the wall", "MoveAhead", "move closer to the logo by 1 m"],
    (FORWARD, 1.4): ["take two steps forward, 1.5 m", "Move forward 2 or 3 steps.", "二歩前に進む"],
    (FORWARD, 1.5): ["move one and a half metres", "move forward one and a half metres",
        "a step forward, approximately 1.5 meters", "take a 1.5 m step forward", "I propel myself forward 1.5m.",
        "Go forward about 1 meter and a half", "我会向前走1.5米，靠近标志。", "Move forward１．５ｍ",
        "Move 1.5 meters straight ahead toward the hatch at the end of the module.", "one and a half metres forward",
        "one point five meters forward", "The best option is to move forward 1.5 m.", "move forward 1,5 m"],
    (FORWARD, 1.8288): ["move forward 2 yards", "Move 6 feet (about 2 m) forward"],
    (FORWARD, 2): ["I will move forward 2 meters.", "2 m forward", "前に2メートル進む",
        "I see the JAXA logo slightly to the left of center, about 4 m away. Move forward 2 m.",
        "I will continue forward for 2 meters.", "Let's keep going straight for another 2 m.",
        '**Next movement:** "Move forward 2 m"', "| action | move forward 2 m |", "Move forward a couple of meters",
        "step forward 2 m", "I'm going to move forward 2 m.", "I am moving forward 2 m.",
        "I do not see the logo and move forward 2 m.", "I can't see the logo so I move forward 2 m",
        "Move forward 2 m and stop.", "Move forward 2 m. Then stop.", "By moving forward 2 m I get closer.",
        "I get closer by moving forward 2 m.", "To get closer I move forward 2 m", "move toward the logo, 2 m forward",
        "move forward along the corridor for 2 m", "Direction: forward\nDistance: 2 m",
        "1. Move forward 2 m.\n2. Turn left 90 degrees.\n\nNext movement: Move forward 2 m.",
        "Plan: turn left 20 degrees.\n\n**Action:**\nMove forward 2 m.",
        "Move forward 2 m. Then the task is completed.", "move forward2m", "Move forward two (2) meters.",
        "Move forward 2 (two) meters", "move forward approx. 2 m", "the right thing is to move forward 2 m",
        "move forward: 2 m", "Float forward 2 meters toward the hatch", "advance 2 m", '"move forward 2 m" -> moved',
        "Thinking... move forward 2 m.", "action=move_forward distance=2", "1) Move forward 2 m",
        "I turned right in the last step. Now I will move forward 2 meters.", "Move forward by 2 m or so.",
        "Move forward at least 2 m.", "I'd need to move forward 2 m.", "walk 2 meters",
        "If I turn left, I will see the door. Move forward 2 m.", "move_forward(2)",
        '{"action": "move forward", "distance": "2 m"}', "\\boxed{move forward 2 m}",
        "右に見えるロゴに近づくため、前に2メートル進みます。", "向前走两米", "move along the corridor forward 2 m",
        "move 2 m toward the logo", '{"move": "forward", "meters": 2}'],
    (FORWARD, 2.1): ["take three steps forward", "take a few steps forward", "take 3 steps"],
    (FORWARD, 2.5): ["Move forward by two and a half meters", "前へ二メートル半進む", "move forward 2½ m"],
    (FORWARD, 3): ["The view shows a hatch straight ahead and several racks on the left and right. I want to get "
        "closer to the hatch, so I'll go forward. Move forward 3 m.",
        "walk straight ahead 3 m"],
    (FORWARD, 3.048): ["move forward 10 feet"],
    (FORWARD, 12): ["move forward 12 m"],
    (20, 2): ["move forward 2 m at an angle of 20 degrees to the left"],
    (30, 2): ["move 2 m at a bearing of 30 degrees to the left"],
    (FORWARD_LEFT, 1): ["forward-left", "move forward and left", "左斜め前に1メートル進む"],
    (LEFT, 0.3): ["Glide left 0.3 m"],
    (LEFT, 0.5): ["strafe left 0.5m", "<think>forward 3 m? no, the table is in the way</think> Strafe left 50cm."],
    (LEFT, 0.7): ["take a small step to the left"],
    (LEFT, 1): ["step to the left", "move sideways to the left 1 m", "go left", "向左走1米", "Move: left"],
    (LEFT, 2): ["- Direction: left\n- Distance: 2 m", "head left 2 m"],
    (BACK, 0.25): ["twenty-five centimetres backward"],
    (BACK, 0.35): ["half a step back"],
    (BACK, 0.5): ["Step back half a meter",
        "Hmm, there is a wall on my left and a door on my right... I guess I'd rather step back half a metre.",
        "0,5 m backward"],
    (BACK, 0.7): ["take a step back"],
    (BACK, 1): ["backward 1 m", "retreat 1 m", "reverse 1 m", "step back to see more", "Move backwards", "back up 1 m",
        "後ろに1メートル下がる", "后退1米"],
    (BACK, 1.4): ["take two small steps back"],
}  # fmt: skip
TURNS: dict[float, list[str]] = {
    -180: ["turn right one hundred and eighty degrees"],
    -120: ["one hundred twenty degrees to the right"],
    -90: ["rotate 90 degrees clockwise", "Because the corridor continues to the right, I'll turn right 90 degrees.",
        "Nothing left to see; turn right 90 degrees.", "RotateRight 90"],
    -45: ["ロゴが見えません。右に45度回転します。", "Turning right by 45 degrees.", "a right turn of 45 degrees"],
    -30: ["Turn right by 30°", "Rotate my view 30 degrees to the right.", "Movement: right 30 degrees",
        "> turn right 30 degrees", "Turn right 30 degrees. I do not need to turn left.",
        "turn toward the door, 30 degrees to the right", "turn right 30 (thirty) degrees",
        "turn right 30 deg. to see the logo", "Turn ~30 degrees right", "turn right by 30-45 degrees",
        "turn right between 30 and 45 degrees", "Turn right. There are 30 racks.", "Turn right: 30 degrees",
        "turn to my right", "turn to the right side", "face right 30 degrees", "３０度右に回転",
        "我看到标志在右边。向右转30度。", "**Decision:** rotate thirty degrees clockwise, please.",
        "Rotate body right: 30 degrees.", "turn right 30 degrees and stay there",
        "First, I look left: nothing. Then I look right: a door.",
        "previously I moved forward 2 m, now turn right 30 degrees", "turn right 30 degrees, not left",
        "It would be best to turn right 30 degrees.", "make a slight right turn",
        "Turn right 30 degrees before moving forward.", "Turn right (clockwise) by 30 degrees.", "turn_right(30)",
        "*turns right 30 degrees*", "$30^\\circ$ to the right", "右を向く",
        "前に進むことができます。右に30度回転します"],
    -20: ["Instead of turning left, I turn right 20 degrees."],
    -15: ["The last movement was forward 2 m. Next, turn right 15 degrees.", "turn a bit right",
        "Final answer: `turn right 15 degrees`", "少し右に回転する"],
    -10: ["Turn so the logo is centered, about 10 degrees right."],
    0: ["turn left 0 degrees"],
    10: ["no movement; just turn left 10 degrees", "Backup plan: turn left 10 degrees."],
    15: ["turn slightly to the left", "Wait, the logo is on the left. Turn left 15 degrees."],
    20: ["I'd like to turn to the left by 20 degrees",
        "I am at (4.00, 20.10), facing 180 degrees. Turn left 20 degrees."],
    30: ["Do not move forward; instead turn left.", "左に30度回転",
        "I was told to move forward, but there's a wall; turn left.", "Next step: 30 degrees to the left",
        "left 30 degrees", "Do not move forward, turn left 30 degrees.",
        "I will not move forward and will turn left 30 degrees instead.",
        "I won't move forward but turn left 30 degrees.", "No, turn left 30 degrees.", "turn left to 90 degrees",
        "turn left, 30 degrees", "proceed to turn left 30 degrees", "face left", "Turn your head left 30 degrees.",
        "左に曲がる", "The logo is about 30 degrees to my left, so I turn left 30 degrees.", "Turn left 1e3 degrees",
        "Turn left 30 degrees while staying in place", "Left or right? Left. Turn left 30 degrees.",
        "Turn left, not right.",
        "Option A: move forward 2 m. Option B: turn left 30 degrees. I choose option B: turn left 30 degrees.",
        "take a left", "move left 30 degrees", "look left",
        "I could turn left or move forward. I will turn left 30 degrees.", "Turn: left",
        "前に進まないで、左に30度回転する"],
    40: ["I should turn my body to the left by about 40 degrees.",
        "Maybe I should turn left. I'll turn left 40 degrees."],
    45: ["Turn: left\nAngle: 45",
        "I see a white cylindrical module interior with many cables. I am currently facing the far end. "
        "The logo isn't visible. I'll rotate to scan the surroundings. Turn left 45 degrees.",
        "rotate counter-clockwise 45 degrees", "rotate anticlockwise by 45°", "turn 45 degrees ccw",
        "I will now turn 45 degrees to my left to face the panel.",
        "What about turning left? Yes: turn left 45 degrees.", "turn left forty-five degrees"],
    60: ["I need to turn left to see the rest of the module. turn left 60 degrees"],
    85.94366927: ["turn left 1.5 radians"],
    90: ["A quarter turn to the left", "Turn around to the left 90 degrees",
        "I don't see the logo here. I will turn left 90 degrees.",
        "Let me think: forward is blocked. Left is open. So turn left 90 degrees.",
        "A good next step would be to turn left 90 degrees.", "a quarter turn to the left",
        "make a 90-degree left turn", "Stay here and turn left 90 degrees.",
        "- **Observation**: a wall 2 m ahead, with a panel on the left.\n- **Action**: turn left 90 degrees"],
    180: ["face the opposite direction", "The logo must be behind me, so turn around.", "後ろを向く",
        "I do not want to move forward. Let me turn around instead!", "turn around", "do a 180", "turn 180 degrees",
        "make a half turn", "振り返る"],
    720: ["turn left 720 degrees"],
}  # fmt: skip
GAZES: dict[float, list[str]] = {
    -20: ["tilt my head down 20 degrees"],
    -15: ["pitch -15 degrees", "look down at the floor", "下を見る"],
    -10: ["Adjust the pitch by -10 degrees.", "低头10度"],
    -7.5: ["lower the camera slightly"],
    5: ["When I turn left, I see the hatch. Look up 5 degrees."],
    7.5: ["look up slightly"],
    10: ["Tilt up 10°", "move the camera up 10 degrees", "Without moving, look up 10 degrees.",
        "let me not move forward, but look up 10 degrees", "raise my gaze by 10 degrees"],
    15: ["Shift my gaze up 15 degrees.", "look up to 30 degrees", "I want to see what is above. Look up."],
    20: ["gaze up 20 degrees", "I will remain in place and look up 20 degrees.", "No need to move. Look up 20 degrees.",
        "抬头20度"],
    30: ["Since the logo is above me, look up 30 degrees.", "turn up 30 degrees", "up 30 degrees", "30 degrees up",
        "上に30度視線を向ける", "stay and look up 30 degrees", "上を30度見上げる"],
    200: ["Look up 200 degrees"],
}  # fmt: skip
STAYS = [
    "No further movement is needed.", "Task completed", "I have reached the goal.",
    "Since I have already reached the target, no further action is required.", "stay here", "動かない",
    "I see no reason to turn. stay", "Stop moving.", "Stop.", "Wait.", "Hold position.", "hold still", "remain here",
    "I'll stay here to observe the surroundings.", "My decision: stay", "stay.", "do nothing", "動きません",
    "ロゴに近づいたので、停止します。", "進まない", "Stay where you are.", "Should I stay or should I go? Stay.",
    "Not moving.", "Do not move.", "I will not move.", "I'll stay in place.", "Move forward 2 m. On reflection, stay.",
    "No movement is needed.", "I have reached the logo, so I will stay.", "その場にとどまる", "原地不动",
]  # fmt: skip
SEVERAL = [
    ("move 3 ft forward and turn left 45 degrees", (FORWARD, 0.9144), 45, None),
    ("向左转30度，然后向前走2米", (FORWARD, 2), 30, None),
    ("The logo is up and to the right. Turn right 15 degrees and look up 10 degrees.", None, -15, 10),
    ("I'll turn back and move forward 1 m.", (FORWARD, 1), 180, None),
    ("Answer: move forward 2m, turn right 30deg, look up 10deg", (FORWARD, 2), -30, 10),
    ("look up at the ceiling and move forward 1 m", (FORWARD, 1), None, 15),
    ("First turn left 30 degrees, and then move forward 1 m, finally look up 5 degrees", (FORWARD, 1), 30, 5),
    ("After turning left 90 degrees, move forward 2 m.", (FORWARD, 2), 90, None),
    ("While moving forward 1 m, look up 10 degrees.", (FORWARD, 1), None, 10),
    ("turn left 30 degrees 2 m forward", (FORWARD, 2), 30, None),
    ("move forward 2 m left 30 degrees", (FORWARD, 2), 30, None),
    ("move left turn right 30", (LEFT, 1), -30, None),
    ("go straight and then turn left", (FORWARD, 1), 30, None),
    ("Move forward 2 m — then turn right 30 degrees", (FORWARD, 2), -30, None),
    ("2 m forward, 30 degrees left", (FORWARD, 2), 30, None),
    ("Go forward one meter and turn right ninety degrees", (FORWARD, 1), -90, None),
    ("Step 1: turn left 30 degrees. Step 2: move forward 1 m.", (FORWARD, 1), 30, None),
    ("まず左に30度回転し、次に前に1メートル進みます。", (FORWARD, 1), 30, None),
    ("Take two steps ahead, then look up slightly.", (FORWARD, 1.4), None, 7.5),
    ("Rotate your body to the right by 15°, then look down by 5°.", None, -15, -5),
    ("Forward 1m. Right 90°.", (FORWARD, 1), -90, None),
    ("1. Turn left 45 degrees\n2. Move forward 1 m", (FORWARD, 1), 45, None),
    ("左に曲がって1メートル進みます", (FORWARD, 1), 30, None),
]

INFERRED = {
    "move one and a half metres", "take 3 steps", "First, I look left: nothing. Then I look right: a door.",
    "walk 2 meters", "move closer to the logo by 1 m", "move along the corridor forward 2 m",
    "move 2 m toward the logo", "move left 30 degrees", "look left", "左に曲がって1メートル進みます",
}  # fmt: skip
"""Replies whose direction or kind of motion had to be inferred."""
NOTHING = [
    "I don't need to turn", "the door on my right", "the left wall", "right now", "left behind",
    "in 3 m there is a wall", "gate 4",
    'Examples of the movement sentence: "move forward 2 m", "turn right 30 degrees",\n"look up 30 degrees", "stay".',
    "left", "right", "move sideways 1 m", "I'll look around.", "look around", "look at the logo",
    "Do not turn left or move forward.", "Do not move forward and turn left 30 degrees.", "Not forward, but left.",
    "It is not necessary to turn left.", "I am not sure I should turn left.", "Avoid moving forward.",
    "Stay close to the left wall.", "stay on course", "wait for the next image", "I will move to the wall and stop.",
    "Turn right 30 degrees. Actually, do not turn.", "approach the logo", "get closer to the logo",
    "move toward the logo, 3 m ahead", "move forward -2 m", "turn to heading 90", "turn to 90 degrees",
    "I turned left, then moved forward; the logo is left of the door.", "My left hand is on the rail.",
    "There are 3 racks left.", "turn onto the left corridor", "turn left clockwise", "move back to the corridor",
    "face the left wall", 'step 3: you said "move forward 2 m" -> moved', "forward is blocked", "left is open",
    "2 m forward is the wall", "Forward 2 m to the wall", "I don't know what to do.", "The answer is 42.", "</s>",
    "左を向いています", "右の壁に近づく", "もし左に進むと壁にぶつかる。", "No gires", "Perhaps a bit forward.",
    "The image shows a corridor with lamps.", "I am not sure what to do here.", "¯\\_(ツ)_/¯", "Gate 4 is 3 m away.",
    'I see a sign that says "turn left".', "There is an arrow pointing to the left.",
    "The camera is looking down at a table.", "My heading is 180 degrees, so the left wall is at 270 degrees.",
    "I'm 2 m from the wall.", "The logo is about 30 degrees to my left.", "The hallway extends forward for about 10 m.",
    "There's a door to the right, 3 m away.", "I'll take the door on the right.",
    "The passage to the right leads back to the hall.", "Move forward 2 m?", "to the left", "Walk up to the wall.",
    "Go down the corridor.", "The picture on the back wall is right above the left panel.",
    "I left the room and moved on.", "Don't move more than 1 m forward.", "Never turn left.",
    "I have no reason to move forward.", "I refuse to move.", "I will neither turn left nor move forward.",
    "Either turn left or turn right.", "I might move forward.", "Unless I turn left I cannot see it.",
    "Once I move forward 2 m I will be there.", "Before moving forward I look up 10 degrees.", "look straight ahead",
    "move up 1 m", "turn left or right", "I can't move forward because a wall blocks me.", "The corridor turns left.",
    "Wall: 2 m ahead.", "It is 2 m to the left.",
    "Turning left is counter-clockwise. You can look up or down, but not straight up or straight down.",
    "Moving forward 2 m would bring me closer.", "Looking up, I see the ceiling.", "Turn right now",
    "Turn to face the logo on the right.", "Turn towards the left wall.", "move to the left of the rack",
    "move right up to the wall", "目の前に壁があります。左にドアがあります。", "不要向前走",
    "Ich gehe 2 m vorwärts und drehe mich um 30 Grad nach links.", "Avanzo 2 metros y giro a la derecha 45 grados.",
    "J'avance de 2 m, puis je tourne à gauche de 30 degrés.",
    "If I have reached the goal, no further movement is needed.", "When I get there, the task is completed.",
    "I doubt that the task is complete.", "Task complete: false", "Previous action:\nTurn left 30 degrees",
]  # fmt: skip
"""Replies that hold no movement."""
READINGS = [
    *((text, Translation(*move), None, None, False) for move, texts in MOVES.items() for text in texts),
    *((text, None, turn, None, False) for turn, texts in TURNS.items() for text in texts),
    *((text, None, None, gaze, False) for gaze, texts in GAZES.items() for text in texts),
    *((text, Translation(*move) if move else None, turn, gaze, False) for text, move, turn, gaze in SEVERAL),
    *((text, None, None, None, True) for text in STAYS),
]


def test_movements_are_read():
    for text, *asked in READINGS:
        command = interpret(text)
        assert [command.translate, command.turn, command.gaze, command.stay] == asked, text
        assert command.outcome is (Outcome.REPAIRED if text in INFERRED else Outcome.CHOSEN), text
        assert command.notes, text


def test_no_movement_is_made_up():
    for text in NOTHING:
        command = interpret(text)
        assert (command.translate, command.turn, command.gaze, command.stay) == (None, None, None, False), text
        assert command.outcome is Outcome.UNREADABLE, text
        assert command.notes, text


MEASURED = {"dev": (140, 140, 0), "held": (132, 125, 5), "vlm": (80, 79, 0)}
"""The replies, those of them that are read exactly, and those with a motion that nobody asked for."""
_TOLERANCE_M, _TOLERANCE_DEG = 0.01, 0.5


def labelled(half: str) -> list[dict[str, Any]]:
    """Return labelled replies: text, move, turn, gaze, stay; of a half also language and kind."""
    lines = Path(__file__).with_name(f"replies_{half}.jsonl").read_text(encoding="utf-8").splitlines()
    return [json.loads(line) for line in lines]


def verdict(label: dict[str, Any], command: Command) -> str:
    """Return `exactly`, `invented` or `missed`."""
    move = None if command.translate is None else (command.translate.bearing, command.translate.distance)
    pairs = [(move, label["move"]), (command.turn, label["turn"]), (command.gaze, label["gaze"])]
    same = [_is_same(read, asked) for read, asked in pairs]
    if all(same) and command.stay == label["stay"]:
        return "exactly"
    return (
        "invented" if any(read is not None and not ok for (read, _), ok in zip(pairs, same, strict=True)) else "missed"
    )


def _is_same(read: Any, asked: Any) -> bool:
    if read is None or asked is None:
        return read is asked
    if isinstance(read, tuple):
        return _is_angle(read[0], asked[0]) and math.isclose(read[1], asked[1], abs_tol=_TOLERANCE_M)
    return _is_angle(read, asked)


def _is_angle(read: float, asked: float) -> bool:
    if abs(abs(read) - 180) < _TOLERANCE_DEG:
        read = math.copysign(read, asked)
    return math.isclose(read, asked, abs_tol=_TOLERANCE_DEG)


@pytest.mark.parametrize("half", MEASURED)
def test_labelled_replies_are_read_at_least_as_well_as_measured(half):
    replies, exactly, invented = MEASURED[half]
    verdicts = [verdict(reply, interpret(reply["text"])) for reply in labelled(half)]
    assert len(verdicts) == replies
    assert verdicts.count("exactly") >= exactly
    assert verdicts.count("invented") <= invented


def test_what_is_told_put_off_or_meant_for_others_is_no_command():
    misread = [reply["text"] for reply in labelled("told") if verdict(reply, interpret(reply["text"])) != "exactly"]
    assert misread == []


COMMANDS = [
    ("Turn left 30 degrees.", (None, 30.0, None)),
    ("My next movement: look down 20 degrees.", (None, None, -20.0)),
    ("I will turn right 45 degrees.", (None, -45.0, None)),
    ("右に30度回転します。", (None, -30.0, None)),
    ("现在向右转45度。", (None, -45.0, None)),
]
MOTIONS = st.sampled_from(["moved forward 2 m", "turned right 60 degrees", "looked up 10 degrees", "walked back 1 m"])
RECAPS = st.sampled_from(
    [
        "In the last step I {}.", "I {} and was stopped by RackA2.", "I have already {}.", "Having {}, I see a door.",
        "After I {}, nothing changed.", "The robot {} and then {}.", "You first {}, then {}.",
        "前のステップで2メートル前進しましたが、ラックにぶつかりました。", "上一步我向前走了2米。",
    ]
)  # fmt: skip


@given(recaps=st.lists(st.tuples(RECAPS, MOTIONS), max_size=4), command=st.sampled_from(COMMANDS))
def test_no_recap_changes_the_command_that_follows_it(recaps, command):
    text, expected = command
    told = " ".join(recap.format(motion, motion) for recap, motion in recaps)
    assert _moved(interpret(told)) == (None, None, None)
    assert _moved(interpret(f"{told} {text}")) == expected


def _moved(command: Command) -> tuple[object, ...]:
    return (command.translate, command.turn, command.gaze)
