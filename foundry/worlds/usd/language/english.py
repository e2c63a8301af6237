"""The English words."""

from __future__ import annotations

from foundry.worlds.usd.language.words import Act, Dimension, Form, Kind, Table, Way, Word, numbers, phrases

_FORMS = (Form.PLAIN, Form.ING, Form.PAST, Form.THIRD)


def _verbs(act: Act, text: str, *ways: Way, goes: bool = False) -> dict[str, Word]:
    """Return the verbs of a text: one line each, its forms as in `move moving moved moves`, blanks written as _."""
    return {
        name.replace("_", " "): Word(Kind.VERB, act=act, form=form, ways=ways, goes=goes)
        for line in text.split("\n")
        for name, form in zip(line.split(), _FORMS, strict=False)
    }


_GO = """move moving moved moves
go going went goes
walk walking walked walks
proceed proceeding proceeded proceeds
continue continuing continued continues
keep_going
head heading_over headed
travel traveling traveled travels
drive driving drove drives
run running ran runs"""

_MOVE = """step stepping stepped
drift drifting drifted drifts
float floating floated floats
glide gliding glided glides
fly flying flew flies
strafe strafing strafed strafes
sidestep sidestepping sidestepped
shift shifting shifted shifts
slide sliding slid slides
translate translating translated translates
push pushing pushed
inch_your_way
propel propelling propelled
crawl crawling crawled"""

_TURN = """turn turning turned turns
rotate rotating rotated rotates
rotation
pivot pivoting pivoted pivots
spin spinning spun spins
swivel swiveling swiveled swivels
yaw yawing yawed yaws
veer veering veered veers
steer steering steered steers
pan panning panned pans
face facing_to
reorient reorienting reoriented"""

_LOOK = """look looking looked
gaze_to
tilt tilting tilted tilts
pitch pitching pitched pitches
glance glancing glanced
peer peering peered
angle_your angling
adjust adjusting adjusted
aim aiming aimed
tilt_head
tilt_the_head
turn_head_up
turn_head_down"""

_VERBS: Table = {
    **_verbs(Act.MOVE, _GO, goes=True),
    **_verbs(Act.MOVE, _MOVE),
    **_verbs(Act.MOVE, "advance advancing advanced advances", Way.FORWARD),
    **_verbs(
        Act.MOVE, "retreat retreating retreated\nback_up backing_up backed_up\nback_off\nback_away\nreverse", Way.BACK
    ),
    **_verbs(Act.TURN, _TURN),
    **_verbs(Act.LOOK, _LOOK),
    **_verbs(Act.LOOK, "raise raising raised\nlift lifting lifted\nraise_head\nlift_head", Way.UP),
    **_verbs(Act.LOOK, "lower lowering lowered\nlower_head", Way.DOWN),
    **_verbs(Act.MAKE, "take taking took takes\nmake making made makes\ndo\nperform\nexecute"),
    **phrases(
        Word(Kind.VERB, act=Act.TURN, ways=(Way.AROUND,), number=180.0),
        "turn around | turn all the way around | turn myself around | turn back around | reverse direction | "
        "turn right around | turn back | turn completely around | spin around | rotate around | u turn | "
        "uturn | about face | about turn | do a 180 | do a one eighty | face the opposite direction | "
        "face the other direction | face the other way | face the opposite way | "
        "face in the opposite direction | face opposite direction | face backward | face backwards | "
        "turn to the opposite direction | face behind me",
    ),
    **phrases(
        Word(Kind.VERB, act=Act.TURN, form=Form.ING, ways=(Way.AROUND,), number=180.0),
        "turning around | turning back | spinning around | rotating around | facing the opposite direction",
    ),
    **phrases(
        Word(Kind.VERB, act=Act.TURN, form=Form.PAST, ways=(Way.AROUND,), number=180.0), "turned around | spun around"
    ),
}

_WAYS: Table = {
    **phrases(
        Word(Kind.WAY, ways=(Way.FORWARD,)),
        "forward | forwards | ahead | straight | straight ahead | straight forward | straight on | onward | "
        "onwards | directly ahead | directly forward | frontward | to the front | in the forward direction | "
        "in a forward direction | dead ahead",
    ),
    **phrases(
        Word(Kind.WAY, ways=(Way.BACK,)),
        "back | backward | backwards | straight back | straight backward | straight backwards | rearward | rearwards",
    ),
    **phrases(
        Word(Kind.WAY, ways=(Way.LEFT,)),
        "left | leftward | leftwards | to the left | to my left | to your left | toward the left | "
        "towards the left | toward my left | towards my left | back to the left | sideways to the left | "
        "sideways left | left hand | counter clockwise | counterclockwise | anticlockwise | anti clockwise | "
        "ccw | port",
    ),
    **phrases(
        Word(Kind.WAY, ways=(Way.RIGHT,)),
        "right | rightward | rightwards | to the right | to my right | to your right | toward the right | "
        "towards the right | toward my right | towards my right | back to the right | "
        "sideways to the right | sideways right | right hand | clockwise | cw | starboard",
    ),
    **phrases(Word(Kind.WAY, ways=(Way.UP,)), "up | upward | upwards | straight up | higher"),
    **phrases(Word(Kind.WAY, ways=(Way.DOWN,)), "down | downward | downwards | straight down | lower down"),
}

_NUMBERS: Table = {
    **numbers(
        "zero=0 one=1 two=2 three=3 four=4 five=5 six=6 seven=7 eight=8 nine=9 ten=10 eleven=11 twelve=12 thirteen=13 "
        "fourteen=14 fifteen=15 sixteen=16 seventeen=17 eighteen=18 nineteen=19 twenty=20 thirty=30 forty=40 fourty=40 "
        "fifty=50 sixty=60 seventy=70 eighty=80 ninety=90 half=0.5 quarter=0.25 quarters=0.25 "
        "thirds=0.3333333333 tenth=0.1 tenths=0.1 couple=2 few=3 full=1"
    ),
    **numbers("hundred=100 thousand=1000", scale=True),
    **phrases(Word(Kind.ARTICLE), "a | an | another"),
    **phrases(Word(Kind.POINT), "point"),
}

_UNITS: Table = {
    **phrases(Word(Kind.UNIT, dimension=Dimension.LENGTH, number=1.0), "m | meter | meters | metre | metres | mtr"),
    **phrases(
        Word(Kind.UNIT, dimension=Dimension.LENGTH, number=0.01),
        "cm | cms | centimeter | centimeters | centimetre | centimetres",
    ),
    **phrases(
        Word(Kind.UNIT, dimension=Dimension.LENGTH, number=0.001),
        "mm | millimeter | millimeters | millimetre | millimetres",
    ),
    **phrases(Word(Kind.UNIT, dimension=Dimension.LENGTH, number=0.1), "dm | decimeter | decimeters | decimetre"),
    **phrases(
        Word(Kind.UNIT, dimension=Dimension.LENGTH, number=1000.0),
        "km | kms | kilometer | kilometers | kilometre | kilometres",
    ),
    **phrases(Word(Kind.UNIT, dimension=Dimension.LENGTH, number=0.3048), "ft | foot | feet"),
    **phrases(Word(Kind.UNIT, dimension=Dimension.LENGTH, number=0.0254), "inch | inches"),
    **phrases(Word(Kind.UNIT, dimension=Dimension.LENGTH, number=0.9144), "yd | yds | yard | yards"),
    **phrases(Word(Kind.UNIT, dimension=Dimension.STEP, number=1.0), "steps | pace | paces | stride | strides"),
    **phrases(Word(Kind.UNIT, dimension=Dimension.ANGLE, number=1.0), "° | deg | degs | degree | degrees"),
    **phrases(Word(Kind.UNIT, dimension=Dimension.ANGLE, number=57.29577951308232), "rad | rads | radian | radians"),
    **phrases(
        Word(Kind.UNIT, dimension=Dimension.OTHER),
        "s | sec | secs | second | seconds | minute | minutes | time | times | % | percent | units | unit | "
        "tiles | m/s | km/h | moves | racks",
    ),
}

_SMALL_AND_STILL: Table = {
    **phrases(
        Word(Kind.SMALL),
        "a bit | a little | a little bit | a tiny bit | a small bit | slightly | a tad | a touch | "
        "a small amount | a small distance | a short distance | a small angle | just a little | "
        "a small movement | a little ways",
    ),
    **phrases(Word(Kind.STAY), "stay | staying | do nothing | no movement | no motion | no action | no move"),
    **phrases(
        Word(Kind.PAUSE),
        "remain | remaining | wait | stop | halt | pause | hold | idle | freeze | stand | stop moving | "
        "hold position | hold my position | keep still | keep | stayed | remain idle",
    ),
    **phrases(
        Word(Kind.PLACE),
        "here | there | still | put | in place | where i am | where you are | in position | stationary | "
        "motionless | at my current position | at the current position | in my current position | "
        "in the current position | idle | at this position | in this position | in my position | "
        "my position | position | at my position | as i am | at my current location | "
        "at the current location | for now | for this step | for a moment | yet | at all | this step | "
        "needed | is needed | required | is required | necessary | is necessary | anymore | any more | "
        "at this time | any further",
    ),
}

_SCOPES: Table = {
    **phrases(
        Word(Kind.NOT, decides=True),
        "not | do not | don't | dont | won't | will not | should not | shouldn't | never | need not | needn't",
    ),
    **phrases(
        Word(Kind.NOT),
        "can not | cannot | can't | cant | did not | didn't | could not | couldn't | would not | wouldn't | "
        "does not | doesn't | has not | hasn't | have not | haven't | had not | hadn't | is not | isn't | "
        "are not | aren't | was not | wasn't | no need | no reason | no point | no use | nor | neither | "
        "instead of | rather than | without | avoid | avoiding | unable | refrain | prevents | prevent | "
        "stop turning | stop rotating | stop walking | stop looking | stop going | no longer | no turn | "
        "no rotation | no turning | no further | forbidden | impossible | fail | failed | against",
    ),
    **phrases(
        Word(Kind.POSSIBLE),
        "can | could | told to | was asked to | were asked to | may | might | able | possible | either | "
        "possibly | maybe | perhaps",
    ),
    **phrases(
        Word(Kind.CONDITION),
        "if | whether | when | whenever | once | unless | until | till | before | because | in case | "
        "as if | since | as soon as | suppose | assuming | why | how",
    ),
    **phrases(
        Word(Kind.EXAMPLE),
        "says | reads | example | examples | eg | such as | for instance | you said | i said | options | options are | "
        "possible movements",
    ),
    **phrases(
        Word(Kind.FRESH),
        "i | i'll | i will | i shall | will | shall | let | let's | let me | lets | we | i should | should | "
        "must | i must | i am | i'm | i need | instead | just | only | rather | simply | i am going to | "
        "i'm going to",
    ),
    **phrases(
        Word(Kind.SEE),
        "see | seeing | find | spot | notice | recognize | recognise | identify | detect | locate | "
        "visible | know | have | in view | in sight",
    ),
    **phrases(
        Word(Kind.IS),
        "is | are | was | were | be | been | would | seems | seem | allows | allow | gives | brings | "
        "makes it | leads | helps | has | reveals | shows",
    ),
    **phrases(
        Word(Kind.JOIN), "and | & | + | then | and then | but | so | plus | however | therefore | while | thus | →"
    ),
    **phrases(Word(Kind.OR), "or | and/or"),
    **phrases(
        Word(Kind.CLOSE),
        "toward | towards | into | through | along | past | from | near | until reaching | in | on | onto | "
        "with | within | sideways | aside | across | over | under | off | around the | turn around the | "
        "turning around the | turned around the | move around | go around | back to the | back to my | "
        "back to where | down the | up the | ahead of | ahead is | in front | behind | beside | "
        "on the left | on the right | on my left | on my right | on your left | on your right | "
        "at the left | at the right | from the left | from the right | left behind | left over | right now | "
        "right away | right here | right there | right ahead | right behind | right next | right in front | "
        "right up | right past | right through | right into | right to the | all right | left side of | "
        "right side of | left and right | right and left | closer | away | facing | approaching | "
        "following | keeping | aligning | getting | heading | which | that | who | where",
    ),
}

_FILLERS: Table = {
    **phrases(
        Word(Kind.GAZE), "gaze | eyes | view | camera | sight | line of sight | eye | viewpoint | my head | your head"
    ),
    **phrases(
        Word(Kind.BY),
        "by | for | approximately | approx | ca | about | roughly | around | by about | of about | between | "
        "at least | at most | no more than | not more than",
    ),
    **phrases(Word(Kind.TO), "to | up by | to about"),
    **phrases(Word(Kind.OF), "of"),
    **phrases(Word(Kind.AT), "at | at an angle of | at a bearing of"),
    **phrases(
        Word(Kind.FILLER),
        "the | my | your | our | body | myself | yourself | me | exactly | further | more | now | please | "
        "once more | again | next | first | last | final | final answer | answer | action | movement | "
        "command | decision | single | this | is to | was to | be to | ok | okay | direction | distance | "
        "angle | side | around my axis | in place | small | short | large | big | good | whole | sharp | "
        "slight | gentle | quick | additional | diagonally | diagonal | also | want | need | going | "
        "have to | try | decide | decided | choose | chosen | plan | intend | think | believe | best | "
        "next step | first step | last step | previous step | final step | current step | the next step | "
        "second step | each step | every step | one step at a time | not only | not just | or so | "
        "immediately | all the way | here's | here is | go ahead and | result | output | response | instruction | "
        "previously | already | straight line | in a straight line | maximum | total | extra | as | "
        "would be | will be | hand side | hand",
    ),
}

ENGLISH: Table = {
    **_FILLERS,
    **_NUMBERS,
    **_UNITS,
    **_WAYS,
    **_SMALL_AND_STILL,
    **_VERBS,
    **_SCOPES,
}
