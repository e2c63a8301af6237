"""English words."""

from itertools import product

from foundry.worlds.camera.language import (
    Act,
    Dimension,
    Form,
    Kind,
    Table,
    Way,
    Word,
    numbers,
    phrases,
)

_FORMS = (Form.PLAIN, Form.ING, Form.PAST, Form.THIRD)


def _verbs(act: Act, text: str, *ways: Way, goes: bool = False) -> dict[str, Word]:
    """Return the verbs of a text with a verb and its forms per line, as in `move moving moved moves`; _ is a blank."""
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
        {
            Word(Kind.VERB, act=Act.TURN, ways=(Way.AROUND,), number=180.0): "turn around | "
            "turn all the way around | turn myself around | turn back around | reverse direction | "
            "turn right around | turn back | turn completely around | spin around | rotate around | u turn | uturn | "
            "about face | about turn | do a 180 | do a one eighty | face the opposite direction | "
            "face the other direction | face the other way | face the opposite way | "
            "face in the opposite direction | face opposite direction | face backward | face backwards | "
            "turn to the opposite direction | face behind me",
            Word(Kind.VERB, act=Act.TURN, form=Form.ING, ways=(Way.AROUND,), number=180.0): "turning around | "
            "turning back | spinning around | rotating around | facing the opposite direction",
            Word(Kind.VERB, act=Act.TURN, form=Form.PAST, ways=(Way.AROUND,), number=180.0): "turned around | "
            "spun around",
        }
    ),
}

_WAYS: Table = phrases(
    {
        Word(Kind.WAY, ways=(Way.FORWARD,)): "forward | forwards | ahead | straight | straight ahead | "
        "straight forward | straight on | onward | onwards | directly ahead | directly forward | frontward | "
        "to the front | in the forward direction | in a forward direction | dead ahead",
        Word(Kind.WAY, ways=(Way.BACK,)): "back | backward | backwards | straight back | straight backward | "
        "straight backwards | rearward | rearwards",
        Word(Kind.WAY, ways=(Way.LEFT,)): "left | leftward | leftwards | to the left | to my left | to your left | "
        "toward the left | towards the left | toward my left | towards my left | back to the left | "
        "sideways to the left | sideways left | left hand | counter clockwise | counterclockwise | anticlockwise | "
        "anti clockwise | ccw | port",
        Word(Kind.WAY, ways=(Way.RIGHT,)): "right | rightward | rightwards | to the right | to my right | "
        "to your right | toward the right | towards the right | toward my right | towards my right | "
        "back to the right | sideways to the right | sideways right | right hand | clockwise | cw | starboard",
        Word(Kind.WAY, ways=(Way.UP,)): "up | upward | upwards | straight up | higher",
        Word(Kind.WAY, ways=(Way.DOWN,)): "down | downward | downwards | straight down | lower down",
    }
)

_NUMBERS: Table = {
    **numbers(
        "zero=0 one=1 two=2 three=3 four=4 five=5 six=6 seven=7 eight=8 nine=9 ten=10 eleven=11 twelve=12 thirteen=13 "
        "fourteen=14 fifteen=15 sixteen=16 seventeen=17 eighteen=18 nineteen=19 twenty=20 thirty=30 forty=40 fourty=40 "
        "fifty=50 sixty=60 seventy=70 eighty=80 ninety=90 half=0.5 quarter=0.25 quarters=0.25 "
        "thirds=0.3333333333 tenth=0.1 tenths=0.1 couple=2 few=3 full=1"
    ),
    **numbers("hundred=100 thousand=1000", scale=True),
    **phrases(
        {
            Word(Kind.ARTICLE): "a | an | another",
            Word(Kind.POINT): "point",
        }
    ),
}

_UNITS: Table = phrases(
    {
        Word(Kind.UNIT, dimension=Dimension.LENGTH, number=1.0): "m | meter | meters | metre | metres | mtr",
        Word(Kind.UNIT, dimension=Dimension.LENGTH, number=0.01): "cm | cms | centimeter | centimeters | "
        "centimetre | centimetres",
        Word(Kind.UNIT, dimension=Dimension.LENGTH, number=0.001): "mm | millimeter | millimeters | millimetre | "
        "millimetres",
        Word(Kind.UNIT, dimension=Dimension.LENGTH, number=0.1): "dm | decimeter | decimeters | decimetre",
        Word(Kind.UNIT, dimension=Dimension.LENGTH, number=1000.0): "km | kms | kilometer | kilometers | kilometre | "
        "kilometres",
        Word(Kind.UNIT, dimension=Dimension.LENGTH, number=0.3048): "ft | foot | feet",
        Word(Kind.UNIT, dimension=Dimension.LENGTH, number=0.0254): "inch | inches",
        Word(Kind.UNIT, dimension=Dimension.LENGTH, number=0.9144): "yd | yds | yard | yards",
        Word(Kind.UNIT, dimension=Dimension.STEP, number=1.0): "steps | pace | paces | stride | strides",
        Word(Kind.UNIT, dimension=Dimension.ANGLE, number=1.0): "° | deg | degs | degree | degrees",
        Word(Kind.UNIT, dimension=Dimension.ANGLE, number=57.29577951308232): "rad | rads | radian | radians",
        Word(Kind.UNIT, dimension=Dimension.OTHER): "s | sec | secs | second | seconds | minute | minutes | time | "
        "times | % | percent | units | unit | tiles | m/s | km/h | moves | racks",
    }
)

_SMALL_AND_STILL: Table = phrases(
    {
        Word(Kind.SMALL): "a bit | a little | a little bit | a tiny bit | a small bit | slightly | a tad | a touch | "
        "a small amount | a small distance | a short distance | a small angle | just a little | a small movement | "
        "a little ways",
        Word(Kind.STAY): "stay | staying | do nothing | no movement | no motion | no action | no move",
        Word(Kind.PAUSE): "remain | remaining | wait | stop | halt | pause | hold | idle | freeze | stand | "
        "stop moving | hold position | hold my position | keep still | keep | remain idle",
        Word(Kind.PAUSE, form=Form.PAST): "stayed | remained | waited | paused | stood still",
        Word(Kind.PLACE): "here | there | still | put | in place | where i am | where you are | in position | "
        "stationary | motionless | at my current position | at the current position | in my current position | "
        "in the current position | idle | at this position | in this position | in my position | my position | "
        "position | at my position | as i am | at my current location | at the current location | for now | "
        "for this step | for a moment | yet | at all | this step | needed | is needed | required | is required | "
        "necessary | is necessary | anymore | any more | at this time | any further",
    }
)

_TASKS = ("task", "mission", "goal", "objective")
_GOALS = ("goal", "target", "destination", "goal location", "target location", "goal position", "target position")
_HAVE = ("i have ", "i have now ", "i have already ", "i have successfully ", "i've ", "i've now ", "i've already ")
_DONE: Table = dict.fromkeys(
    map(
        "".join,
        (
            *product(
                _TASKS,
                (" ", " is ", " is now ", " has been "),
                ("complete", "completed", "accomplished", "achieved", "reached", "finished"),
            ),
            *product(_HAVE, ("reached ",), ("the ", "my "), _GOALS),
            *product(_HAVE, ("completed ", "finished ", "accomplished "), ("the ", "my "), _TASKS),
            *product(
                ("no further ", "no more ", "no additional "),
                ("movement ", "movements ", "motion ", "action ", "actions ", "move ", "moves "),
                ("", "is ", "are "),
                ("needed", "required", "necessary"),
            ),
        ),
    ),
    Word(Kind.DONE),
)

_TELLING: Table = phrases(
    {
        Word(Kind.EARLIER): "in the last step | in my last step | last step | in the previous step | "
        "in my previous step | previous step | previous steps | in the last turn | last turn | previous turn | "
        "last move | previous move | last movement | previous movement | last movements | previous movements | "
        "last action | previous action | previous actions | last command | previous command | last decision | "
        "previous decision | last attempt | previous attempt | last time | previous time | last reply | "
        "previous reply | last answer | previous answer | previous rotation | last rotation | most recent movement | "
        "most recent move | most recent action | most recent step | earlier step | earlier steps | earlier turn | "
        "earlier move | earlier movement | in the step before | the step before | two steps ago | a step ago | "
        "a moment ago | earlier | previously | recently | so far | just before | in the past | i said | you said | "
        "i replied | i answered | you replied | i chose to say | i responded | past steps | past movements | "
        "past actions | first movement was | my history | the history",
        Word(Kind.PAST): "tried to | attempted to | my attempt to | attempts to | attempt at | the attempt to | "
        "my attempts to | attempted | tried | wanted to | was going to | was about to | was supposed to | had to | "
        "used to | managed to | started to | began to | started | began | continued to | continued | "
        "my plan was to | intended to | my decision was to | i chose to | i was told to | executed | performed | "
        "completed | carried out | finished | instructed to | my choice was to",
        Word(Kind.AFTER): "after | after my | upon",
        Word(Kind.NOW): "now | this time | at this point | for the moment | right at this point | at present | "
        "this turn | my next movement | my next single movement | my next action | my next move | "
        "the next movement | the next single movement | next movement | next single movement | next action | "
        "my movement | my action | my decision | my answer | final decision | my single movement | "
        "the movement for this step",
        Word(Kind.LATER): "later | later on | afterwards | afterward | eventually | next time | the next time | "
        "after this | after that | after this movement | after this step | after this turn | after this move | "
        "after which | in the future | in a later step | in later steps | in a future step | in my next decision | "
        "in the next decision | at a later point | at a later time | in the step after | the step after | "
        "in the steps after | some day | in subsequent steps | in a subsequent step | in upcoming steps | "
        "only after | only once | only when | not yet | before long | once i have | once i've | once i am | "
        "once i'm | after i have | after i've | as soon as i have | as soon as i | once that is done | "
        "once this is done | when that is done | when this is done | after doing so | in two steps | "
        "sooner or later | at some point | then in my next | soon | in a moment | when i have | when i've | "
        "when i am | when i'm | in the long run | tomorrow | on the next turn | in the following decision | "
        "in the turn after",
        Word(Kind.NEXT): "in the next step | in my next step | in the next turn | in my next turn | "
        "in the following step | in the next move | in my next move | in the following turn | in the next movement | "
        "in my next movement | in the coming step | next decision | following decision | following step | "
        "for the next step | for the next turn | at the next step | on the next step | on my next turn | "
        "with the next step | the step after next | the following step | in the next one | next one | next steps | "
        "in the next steps | for the next steps | next turn",
        Word(Kind.FIRST): "but first | but before that | but for now | however first | but first of all | "
        "though first | before doing that | before doing so | before that | but before doing so | first though | "
        "but right now | but now",
        Word(Kind.RETRACT): "no wait | no, wait | wait no | wait, no | no, | oh wait | oh, wait | but wait | "
        "hold on | actually, | scratch that | correction | on second thought | on second thoughts | i mean | "
        "i meant | i correct myself | sorry, | let me correct | oops | oops, | or rather | better: | on reflection | "
        "let me reconsider | let me revise | i change my mind | i changed my mind | hmm, no | strike that | "
        "never mind | forget that | wait, actually | i misspoke | rather: | no.",
        Word(Kind.OTHER): "robot | agent | person | man | woman | astronaut | human | somebody | someone | he | "
        "she | it | they | worker | engineer | scientist | drone | child | boy | girl | character | player | "
        "visitor | figure | guy | lady | dog | cat | vehicle | cart | car | rover | crew member | member | nobody | "
        "another robot | staff | student | guard | employee | individual | pedestrian | colleague | walker",
        Word(Kind.OTHER, scale=True): "robots | people | persons | astronauts | men | women | humans | agents | "
        "workers | others | crew members | scientists | visitors | children | students | figures | they",
        Word(Kind.GOAL): "goal | task | objective | aim | purpose | mission | assignment | idea behind | reason",
        Word(Kind.PURPOSE): "in order to | so as to | so that | in order that | be able to | in preparation for | "
        "to prepare for | ready for | before i can | allow me to | allows me to | will allow me to | "
        "would allow me to | enable me to | enables me to | will enable me to | let me then | will let me | "
        "would let me | lets me | help me | helps me | will help me | help me to | would help me | "
        "give me a chance to | with the aim of | with the goal of | for the purpose of | makes it possible to | "
        "allowing me to | enabling me to | letting me | helping me | possible to | way to | path to | room to | "
        "space to | chance to | opportunity to | as preparation for | with a view to",
        Word(Kind.OPTION): "option a | option b | option c | option d | option 1 | option 2 | option 3 | option 4 | "
        "option one | option two | option three | choice a | choice b | choice 1 | choice 2 | alternative a | "
        "alternative 1 | alternative b | alternative 2",
    }
)

_SCOPES: Table = {
    **phrases(
        {
            Word(Kind.NOT, decides=True): "not | do not | don't | dont | won't | will not | should not | shouldn't | "
            "never | need not | needn't",
            Word(Kind.NOT): "can not | cannot | can't | cant | did not | didn't | could not | couldn't | would not | "
            "wouldn't | does not | doesn't | has not | hasn't | have not | haven't | had not | hadn't | is not | "
            "isn't | are not | aren't | wasn't | no need | no reason | no point | no use | nor | neither | "
            "instead of | rather than | without | avoid | avoiding | unable | refrain | prevents | prevent | "
            "stop turning | stop rotating | stop walking | stop looking | stop going | no longer | no turn | "
            "no rotation | no turning | no further | forbidden | impossible | fail | against",
            Word(Kind.POSSIBLE): "can | could | told to | was asked to | were asked to | may | might | able | "
            "possible | either | possibly | maybe | perhaps",
            Word(Kind.CONDITION): "if | whether | when | whenever | once | unless | until | till | before | "
            "because | in case | as if | since | as soon as | suppose | assuming | why | how",
            Word(Kind.EXAMPLE): "says | reads | example | examples | eg | such as | for instance | options | "
            "options are | possible movements | possible actions | possible moves",
        }
    ),
    **_TELLING,
    **phrases(
        {
            Word(Kind.FRESH): "i | i'll | i will | i shall | will | shall | let | let's | let me | lets | we | "
            "i should | should | must | i must | i am | i'm | i need | instead | just | only | rather | simply | "
            "i am going to | i'm going to",
            Word(Kind.SEE): "see | seeing | find | spot | notice | recognize | recognise | identify | detect | "
            "locate | visible | know | have | in view | in sight",
            Word(Kind.IS): "is | are | be | would | seems | seem | requires | means | depends | gives | brings | "
            "makes it | leads | helps | reveals | shows",
            Word(Kind.IS, form=Form.PAST): "was | were | been | had | has | has been | had been | i'd been | did | "
            "i've been | have been | was not | were not | had not",
            Word(Kind.UNKNOWN, form=Form.PAST): "got | brought | ended | noticed | caused | resulted | revealed | "
            "showed | helped | allowed | led | became | hit | reached | bumped | collided | made it | made me | "
            "kept | found | saw | worked | failed | stopped | blocked | prevented",
            Word(Kind.JOIN): "and | & | + | then | and then | but | so | plus | however | therefore | while | thus | →",
            Word(Kind.OR): "or | and/or",
            Word(Kind.CLOSE): "toward | towards | into | through | along | past | from | near | until reaching | "
            "in | on | onto | with | within | sideways | aside | across | over | under | off | around the | "
            "turn around the | turning around the | turned around the | move around | go around | back to the | "
            "back to my | back to where | down the | up the | ahead of | ahead is | in front | behind | beside | "
            "on the left | on the right | on my left | on my right | on your left | on your right | at the left | "
            "at the right | from the left | from the right | left behind | left over | right now | right away | "
            "right here | right there | right ahead | right behind | right next | right in front | right up | "
            "right past | right through | right into | right to the | all right | left side of | right side of | "
            "left and right | right and left | closer | away | facing | approaching | following | keeping | "
            "aligning | getting | heading | which | that | who | where",
        }
    ),
}

_FILLERS: Table = phrases(
    {
        Word(Kind.GAZE): "gaze | eyes | view | camera | sight | line of sight | eye | viewpoint | my head | your head",
        Word(Kind.BY): "by | for | approximately | approx | ca | about | roughly | around | by about | of about | "
        "between | at least | at most | no more than | not more than",
        Word(Kind.TO): "to | to about",
        Word(Kind.OF): "of",
        Word(Kind.AT): "at | at an angle of | at a bearing of",
        Word(Kind.FILLER): "the | my | your | our | body | myself | yourself | me | exactly | further | more | "
        "please | once again | once more | again | option | choice | strategy | suggest | recommend | propose | "
        "consider | start | begin | course of action | thing to do | attempt | prefer | next | first | last | "
        "final | final answer | answer | action | movement | command | decision | single | this | is to | was to | "
        "be to | ok | okay | direction | distance | angle | side | around my axis | in place | small | short | "
        "large | big | good | whole | sharp | slight | gentle | quick | additional | diagonally | diagonal | also | "
        "want | need | going | have to | try | decide | decided | choose | chosen | plan | intend | think | "
        "believe | best | next step | first step | final step | current step | the next step | second step | "
        "each step | every step | one step at a time | not only | not just | or so | immediately | all the way | "
        "here's | here is | go ahead and | result | output | response | instruction | already | straight line | "
        "in a straight line | maximum | total | extra | as | would be | will be | hand side | hand",
    }
)

ENGLISH: Table = {
    **_FILLERS,
    **_NUMBERS,
    **_UNITS,
    **_WAYS,
    **_SMALL_AND_STILL,
    **_VERBS,
    **_SCOPES,
    **_DONE,
}
