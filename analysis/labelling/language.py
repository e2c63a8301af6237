"""Recognises texts in English and Japanese, which are the languages of the rules.

The script of most letters in the text decides first. A text in Chinese characters and kana is Japanese if it has
hiragana. Without hiragana, a text in Chinese characters or kana is Japanese unless it has a Chinese word or character
that Japanese does not use. A text in Latin letters is English if enough of its words are common English words. A text
in any other script is neither English nor Japanese. The test for English ignores names with digits, and words that many
languages share. A text that has nothing but ignored words, or no letters, counts as English or Japanese.
"""

import re

_ENGLISH_SHARE = 0.2
"""A text counts as English if at least this share of its words are common English words."""

_SEEN_LENGTH = 1600
"""Only this number of characters at the start of a text is examined."""

_LETTERS = re.compile(r"[^\W\d_]")
_LATIN = re.compile("[a-z\u00aa-\u024f\u1e00-\u1eff]")
_HIRAGANA = re.compile("[\u3041-\u3096]")
_KANA = re.compile("[\u3041-\u30ff\uff66-\uff9f]")
_HAN = re.compile("[\u2e80-\u2fdf\u3005-\u3007\u3400-\u9fff\uf900-\ufaff\U00020000-\U0003ffff]")
_CHINESE = re.compile(
    "[我你妳她們沒這那哪嗎吧呢啊很烟]|(?<![完終修満魅])了(?!解|承)|(?<![皇太])后|不要|不是|快跑|快逃|向[前左右]|向[上下]看|[0-9半]米"
)
"""Characters and words that show that a text is Chinese, not Japanese."""

_NAMES = re.compile("[a-z]*[0-9][a-z0-9]*")
_WORDS = re.compile("[a-z\u00aa-\u024f\u1e00-\u1eff]+(?:'[a-z]+)?")


def _listed(words: str) -> frozenset[str]:
    return frozenset(words.split())


_SHARED = _listed(
    """
    agent all also am an area as at attention bar cafe café camera can change danger die direction directions
    distance do find fine had has he hey hi idea image in is let man me meter moment most museum must no not object
    of oh ok okay on or over park part place plan position possible scene so stop to us warm warn was we west zone
    """
)
"""Words that also occur in other languages, and names of places; the test for English ignores them."""

_COMMON = _listed(
    """
    about above across action actually advance after again against agents agreed ahead alive almost alone along
    already although always and another answer any anybody anyone anything anyway anywhere approach are aren't
    around arrive arrived asap ask asked avoid away back backward backwards bad bakery be because been before began
    behind being believe below beside besides better between beware big blaze blazing book books bookshop both brb
    breakfast bridge bring broken brought building burn burned burning burns burnt busy but buy by bye call called
    calm came can't cannot care careful catch caught cause cell chair chance chapter chat check chose city clear
    close closer cold come coming command completed continue cool corner corridor could couldn't couple course cross
    crossing crowd damage dangerous day dead deadly decided deep degree degrees desk detected did didn't dinner does
    doesn't dog doing don't done dont door down dream drill drink drinks drive during each early east easy eat
    eating either else emergency empty end enjoy enough entrance escape evacuate evacuated evacuating evacuation
    even ever every everybody everybody's everyone everything everywhere exit extinguished eye eyes face facing
    false family fantastic far fast feel feels few fight fire fires first flame flames flee fog follow food for
    forest forget forward found fountain free friend friends from front full fun game garden gather get gets getting
    give glad go goes going gone gonna good got grab great group grow growing gtfo guess guys hallway hands happen
    happened happening happy hard hasn't hatch hate have haven't having hazard hazards he's head headed heading
    heads health hear heard heat heavy hello help her here here's hers hidden him his hold home hope hot hotter hour
    hours house how hungry hurry hurt i'd i'll i'm i've if inform injured inside instead interesting into invite
    isn't it it's its join joke jump just keep keeping kill killed kitchen knew know known last late later laugh
    lead leading least leave leaving left leftward less let's library lights like likely line listen little live
    living lol long longer look looking looks lose lost lot lots love lovely low lunch made make makes manage many
    map may maybe mean meaning meet meeting meters metres middle might mind mine miss mist money month months more
    morning move moved movement moves moving much music my name near nearby need needs neighbor neighbors neighbour
    neighbours neither never new news next nice night nine nobody noise none noone nor north nothing notice noticed
    now number numbers observe off older omg once one only onto opening orders other others our ourselves out
    outside outskirts own owner paper party pass passed peaceful people perhaps phone picked picture places planning
    play playing please plenty poor pose pretty printer proceed proceeding pull pushed quick quickly quiet quite
    rain rather reach reached read reading ready really reason relax relocating remain remains remember reply report
    reported rest right rightward road roof room rooms rotate run running sad safe safely safety said same sat save
    saw say saying says school seat second seconds see seeing seek seem seems seen send sent seriously several shall
    shared sharing she she's shelf shop short should shouldn't shut sick side sides signs since sitting six size sky
    sleep slow slowly small smell smelled smelling smells smoke smoky some somebody someone something somewhere song
    soon sorry sorts sound sounds south space speak spot spread spreading stand standing stars start started
    starting starts states station stay stayed staying steam step steps stick still stopped stops story straight
    street strong such suddenly suggest suit sun supposed sure surely swear table take taken taking talk talking
    target task taste tea tell terrible than thank thanks that that's the their them then there there's these they
    they're thing things think thinking third this those though thought thoughts three through till time tired today
    together told tomorrow tonight too took top touch touching toward towards tower town track tree tried trip
    trouble true trust truth try trying turn turned turning turns twice two unable under understand understood
    unless unsafe unsure until up update upstairs ur use used using usual value very view visible visit voice wait
    waiting wake walk walked walking wall walls want wants warned warning wasn't watch watching water wave way ways
    we'll we're we've wear week weeks weird welcome well went were weren't what what's when where where's wherever
    whether which while white whiteboard who who's whole why wide wife will window wish with within without woman
    women won't wonder wonderful wood word words work working works world worried worry worse would wouldn't write
    wrong yeah year years yes yesterday yet you you'd you'll you're you've young your yours yourself zero
    """
)
"""Common English words, including words of messages about a fire and of walks."""


def is_read(text: str) -> bool:
    """Return whether a text in lower case is English or Japanese; names, and texts without letters, count as both."""
    seen = _NAMES.sub(" ", text[:_SEEN_LENGTH])
    letters, latin, han, kana = (len(kind.findall(seen)) for kind in (_LETTERS, _LATIN, _HAN, _KANA))
    if 2 * (han + kana) > letters:
        return _is_japanese(seen)
    return not letters or (2 * latin >= letters and _is_english(seen))


def _is_japanese(text: str) -> bool:
    if _HIRAGANA.search(text):
        return True
    return not _CHINESE.search(text) and all(map(_is_in_japanese_standard, _HAN.findall(text)))


def _is_in_japanese_standard(character: str) -> bool:
    try:
        character.encode("shift_jis")
    except UnicodeEncodeError:
        return False
    return True


def _is_english(text: str) -> bool:
    words = [word for word in _WORDS.findall(text) if len(word) > 1 and word not in _SHARED]
    return sum(word in _COMMON for word in words) >= _ENGLISH_SHARE * len(words)
