"""The basic words of German, Spanish and French; what they tell instead of asking is in `narrated`."""

from __future__ import annotations

from foundry.worlds.camera.language.vocabulary.words import (
    Act,
    Dimension,
    Form,
    Kind,
    Side,
    Table,
    Way,
    Word,
    numbers,
    phrases,
)

_METRE = Word(Kind.UNIT, dimension=Dimension.LENGTH, number=1.0)
_CENTIMETRE = Word(Kind.UNIT, dimension=Dimension.LENGTH, number=0.01)
_STEPS = Word(Kind.UNIT, dimension=Dimension.STEP, number=1.0)
_DEGREE = Word(Kind.UNIT, dimension=Dimension.ANGLE, number=1.0)
_FORWARD, _BACK = Word(Kind.WAY, ways=(Way.FORWARD,)), Word(Kind.WAY, ways=(Way.BACK,))
_LEFT, _RIGHT = Word(Kind.WAY, ways=(Way.LEFT,)), Word(Kind.WAY, ways=(Way.RIGHT,))
_UP, _DOWN = Word(Kind.WAY, ways=(Way.UP,)), Word(Kind.WAY, ways=(Way.DOWN,))
_MOVE, _TURN, _LOOK = (Word(Kind.VERB, act=act, goes=True) for act in (Act.MOVE, Act.TURN, Act.LOOK))
_MAKE = Word(Kind.VERB, act=Act.MAKE)
_AROUND = Word(Kind.VERB, act=Act.TURN, ways=(Way.AROUND,), number=180.0)


def _verbs(act: Act, forms: str, *ways: Way) -> dict[str, Word]:
    """Return a table of verbs from "infinitive, ... | of oneself or another, ... | of oneself, ... | gerund, ..."."""
    kinds = (Form.PLAIN, Form.EITHER, Form.FIRST, Form.ING)
    return {
        name.strip(): Word(Kind.VERB, act=act, form=form, ways=ways, goes=not ways)
        for names, form in zip(forms.split("|"), kinds, strict=True)
        for name in names.split(",")
        if name.strip()
    }


def _negated(verbs: str) -> dict[str, Word]:
    """Return a table of "no" and a verb; a blank in it is written as _."""
    turns = ("giro", "roto", "gira", "giraré")
    return {
        f"no {verb.replace('_', ' ')}": Word(
            Kind.VERB, act=Act.TURN if verb in turns else Act.LOOK if verb == "miro" else Act.MOVE, negated=True
        )
        for verb in verbs.split()
    }


GERMAN: Table = {
    **phrases(
        _MOVE, "gehe | geh | laufe | lauf | bewege | beweg | fahre | fahr | schwebe | trete | tritt | rücke | gleite"
    ),
    **phrases(
        Word(Kind.VERB, act=Act.MOVE, side=Side.BEFORE, goes=True),
        "gehen | laufen | bewegen | fahren | schweben | treten | gleiten",
    ),
    **phrases(
        Word(Kind.VERB, act=Act.MOVE, side=Side.BEFORE, ways=(Way.BACK,)),
        "zurückgehen | zurücktreten | zurückfahren | zurückweichen | zurücksetzen | zurückbewegen",
    ),
    **phrases(
        Word(Kind.VERB, act=Act.MOVE, side=Side.BEFORE, ways=(Way.FORWARD,)),
        "vorgehen | vorwärtsgehen | vorrücken | vorfahren | vorwärtsfahren | vorwärtsbewegen",
    ),
    **phrases(_MAKE, "mache | mach | machen"),
    **phrases(
        _TURN, "drehe | dreh | rotiere | wende | schwenke | biege | drehung | rechtsdrehung um | linksdrehung um"
    ),
    **phrases(Word(Kind.VERB, act=Act.TURN, side=Side.BEFORE), "drehen | rotieren | wenden | schwenken | abbiegen"),
    **phrases(_AROUND, "umdrehen | wende mich um | drehe mich um | dreh dich um | drehe dich um | kehre um"),
    **phrases(
        Word(Kind.FILLER),
        "drehe mich um meine achse | mich | dich | sich | meinen körper | den körper | weiter | weitere | bitte | "
        "lieber | dafür | erstmal | gleich | sofort | langsam | vorsichtig | genau | nur | mal | "
        "circa | rund | ganz | daraufhin | zuerst | "
        "zunächst | bereits | schon | noch | einmal | wieder | erneut | der | die | das | den | nächste | "
        "nächster | ist",
    ),
    **phrases(_LOOK, "schaue | schau | blicke | blick | sieh | neige | neig | richte | kippe"),
    **phrases(Word(Kind.VERB, act=Act.LOOK, side=Side.BEFORE), "schauen | blicken | neigen | richten"),
    **phrases(Word(Kind.VERB, act=Act.LOOK, ways=(Way.UP,)), "hebe | heb"),
    **phrases(Word(Kind.VERB, act=Act.LOOK, ways=(Way.DOWN,)), "senke | senk"),
    **phrases(Word(Kind.VERB, act=Act.LOOK, side=Side.BEFORE, ways=(Way.UP,)), "heben | anheben"),
    **phrases(Word(Kind.VERB, act=Act.LOOK, side=Side.BEFORE, ways=(Way.DOWN,)), "senken | absenken"),
    **phrases(
        Word(Kind.GAZE),
        "den blick | meinen blick | die kamera | meine kamera | den kopf | meinen kopf | die augen | kopf | kamera",
    ),
    **phrases(_FORWARD, "vorwärts | nach vorne | nach vorn | geradeaus | vor | voran"),
    **phrases(_BACK, "rückwärts | zurück | nach hinten"),
    **phrases(_LEFT, "links | nach links | linksherum | gegen den uhrzeigersinn"),
    **phrases(_RIGHT, "rechts | nach rechts | rechtsherum | im uhrzeigersinn"),
    **phrases(_UP, "nach oben | aufwärts"),
    **phrases(_DOWN, "nach unten | abwärts"),
    **phrases(_METRE, "metern"),
    **phrases(_CENTIMETRE, "zentimeter | zentimetern"),
    **phrases(_STEPS, "schritt | schritte | schritten"),
    **phrases(_DEGREE, "grad"),
    **phrases(
        Word(Kind.STAY),
        "bleibe stehen | bleib stehen | stehen bleiben | bleibe hier | bleib hier | bleibe ich stehen | "
        "bleibe ich hier | "
        "bleibe an ort und stelle | bleibe an meinem platz | bleibe in position | bleibe an meiner stelle | "
        "bleibe an meiner position | hier bleiben | bleibe wo ich bin",
    ),
    **phrases(Word(Kind.PAUSE), "warte | warten | bleibe | bleib"),
    **phrases(Word(Kind.NOT, reach="both", decides=True), "nicht"),
    **phrases(Word(Kind.NOT), "ohne | statt | anstatt"),
    **phrases(Word(Kind.POSSIBLE), "kann | könnte | vielleicht"),
    **phrases(Word(Kind.CONDITION), "wenn | falls | weil | bevor | ob | nachdem | sobald | während"),
    **phrases(Word(Kind.EXAMPLE), "beispiel | beispiele | zum beispiel"),
    **phrases(
        Word(Kind.JOIN),
        "und | dann | sondern | aber | daher | deshalb | darum | also | deswegen | danach | anschließend | doch",
    ),
    **phrases(Word(Kind.OR), "oder"),
    **phrases(
        Word(Kind.FRESH),
        "ich | werde | ich werde | stattdessen | sollte ich | muss ich | ich muss | ich sollte | möchte",
    ),
    **phrases(Word(Kind.BY), "um | etwa | ungefähr"),
    **phrases(Word(Kind.SMALL), "ein bisschen | ein wenig | leicht | etwas | ein kleines stück | ein stück"),
    **phrases(Word(Kind.ARTICLE), "ein | eine | einen"),
    **phrases(
        Word(Kind.CLOSE),
        "zur | zum | zu | auf der | durch | in richtung | richtung | entlang | auf die | auf den | auf das | "
        "durch die | durch den | rechts von | links von",
    ),
    **numbers("eins=1 zwei=2 drei=3 vier=4 fünf=5 sechs=6 zehn=10 fünfzehn=15 zwanzig=20 dreißig=30 halb=0.5 "),
    **numbers("halben=0.5 halber=0.5 halbe=0.5 anderthalb=1.5 neunzig=90 fünfundvierzig=45 sechzig=60"),
}

SPANISH: Table = {
    **_verbs(Act.MOVE, "avanzar | avanza, avance | avanzo, avanzaré | avanzando", Way.FORWARD),
    **_verbs(
        Act.MOVE, "retroceder | retrocede, retroceda | retrocedo, retrocederé, me retiro | retrocediendo", Way.BACK
    ),
    **_verbs(
        Act.MOVE,
        "mover, moverme, desplazarme, caminar, ir | mueve, camina, camine, desplaza | muévete, me muevo, me moveré, "
        "camino, caminaré, me desplazo, me desplazaré, desplázate, sigo, voy | moviéndome, caminando",
    ),
    **_verbs(
        Act.TURN,
        "girar, girarme, rotar, voltear | gira, gire, rota, rote, voltea | giro, giraré, roto, rotaré, me giro, "
        "volteo, doblo | girando, rotando",
    ),
    **phrases(_AROUND, "da la vuelta | date la vuelta | media vuelta | dar la vuelta | darme la vuelta"),
    **_verbs(
        Act.LOOK, "mirar, inclinar | mira, mire, inclina, dirige | miro, miraré, inclino, inclinaré, dirijo | mirando"
    ),
    **_verbs(Act.LOOK, "levantar, subir, alzar | levanta, alza | levanto, levantaré, subo, alzo, elevo |", Way.UP),
    **_verbs(Act.LOOK, "bajar | baja | bajo, bajaré |", Way.DOWN),
    **phrases(_MAKE, "doy | dar | dé | hago"),
    **phrases(
        Word(Kind.GAZE),
        "la mirada | la vista | la cámara | la cabeza | los ojos | mi mirada | mi vista | mi cabeza | mi cámara",
    ),
    **phrases(_FORWARD, "adelante | hacia adelante | hacia delante | recto | todo recto | en línea recta | de frente"),
    **phrases(_BACK, "atrás | hacia atrás"),
    **phrases(_LEFT, "izquierda | a la izquierda | hacia la izquierda | a mi izquierda | en sentido antihorario"),
    **phrases(_RIGHT, "derecha | a la derecha | hacia la derecha | a mi derecha | en sentido horario"),
    **phrases(_UP, "arriba | hacia arriba"),
    **phrases(_DOWN, "abajo | hacia abajo"),
    **phrases(_METRE, "metro | metros"),
    **phrases(_CENTIMETRE, "centímetro | centímetros"),
    **phrases(_STEPS, "paso | pasos"),
    **phrases(_DEGREE, "grado | grados"),
    **phrases(
        Word(Kind.STAY),
        "no te muevas | no me muevo | permanezco | permanecer | quédate | quedarme | me quedo | me quedaré | quedarse",
    ),
    **phrases(
        Word(Kind.PLACE), "quieto | quieta | aquí | en mi lugar | en mi posición | en el lugar | donde estoy | inmóvil"
    ),
    **phrases(
        Word(Kind.NOT),
        "no avances | no avanzar | no gires | no girar | no voy a | no debo | no puedo | no es posible | no se puede | "
        "no podemos | sin | en lugar de | en vez de",
    ),
    **phrases(Word(Kind.POSSIBLE), "puedo | podría"),
    **phrases(Word(Kind.EXAMPLE), "ejemplo | ejemplos | por ejemplo"),
    **phrases(
        Word(Kind.JOIN),
        "y | luego | y luego | pero | después | sino | sino que | entonces | así que | por lo tanto | por eso",
    ),
    **phrases(Word(Kind.OR), "o"),
    **phrases(Word(Kind.SMALL), "un poco | ligeramente | un poquito"),
    **phrases(Word(Kind.ARTICLE), "un | una | uno"),
    **phrases(Word(Kind.FRESH), "voy a | yo | vamos a | debo | necesito | tengo que | quiero"),
    **phrases(
        Word(Kind.FILLER), "ahora mismo | aproximadamente | primero | el | la | los | mi | me | otros | otro | más"
    ),
    **phrases(Word(Kind.CLOSE), "hacia la | hacia el | por el | por la | a lo largo de"),
    **phrases(Word(Kind.CONDITION), "si | cuando | porque | antes de | hasta que"),
    **_negated("avanzo retrocedo giro roto miro camino muevo me_muevo avanza gira avanzaré giraré"),
    **numbers("dos=2 tres=3 cuatro=4 cinco=5 diez=10 medio=0.5 treinta=30 noventa=90 cuarenta=40"),
}

FRENCH: Table = {
    **_verbs(Act.MOVE, "avancer | avance | avancez, avancerai, avançons | avançant", Way.FORWARD),
    **_verbs(Act.MOVE, "reculer | recule | reculez, reculerai | reculant", Way.BACK),
    **_verbs(
        Act.MOVE, "bouger, déplacer, marcher | bouge, déplace, marche | bougez, déplacez, marchez, vais | marchant"
    ),
    **_verbs(
        Act.TURN,
        "tourner, pivoter, faire pivoter | tourne, pivote | tournez, tournerai, pivotez, pivoterai | "
        "tournant, pivotant",
    ),
    **phrases(_AROUND, "fais demi tour | faire demi tour | demi tour"),
    **_verbs(
        Act.LOOK, "regarder, incliner, diriger | regarde, incline, dirige, oriente | regardez, regarderai | regardant"
    ),
    **_verbs(Act.LOOK, "lever, relever | lève, relève | lèverai |", Way.UP),
    **_verbs(Act.LOOK, "baisser, abaisser | baisse, abaisse | baisserai |", Way.DOWN),
    **phrases(_MAKE, "fais | faire"),
    **phrases(
        Word(Kind.GAZE),
        "le regard | mon regard | les yeux | la tête | la caméra | ma tête | ma caméra | mes yeux | la vue",
    ),
    **phrases(_FORWARD, "tout droit | en avant | vers l'avant | droit devant"),
    **phrases(_BACK, "en arrière | vers l'arrière"),
    **phrases(_LEFT, "gauche | à gauche | vers la gauche | sur la gauche | vers ma gauche | dans le sens antihoraire"),
    **phrases(_RIGHT, "droite | à droite | vers la droite | sur la droite | vers ma droite | dans le sens horaire"),
    **phrases(_UP, "en haut | vers le haut"),
    **phrases(_DOWN, "en bas | vers le bas"),
    **phrases(_METRE, "mètre | mètres"),
    **phrases(_CENTIMETRE, "centimètre | centimètres"),
    **phrases(_DEGREE, "degré | degrés"),
    **phrases(Word(Kind.STAY), "reste | rester | restez | ne bouge pas | demeure | je ne bouge pas"),
    **phrases(Word(Kind.PLACE), "ici | sur place | immobile | en place | où je suis | à ma position"),
    **phrases(Word(Kind.NOT, reach="both", decides=True), "pas"),
    **phrases(Word(Kind.NOT, decides=True), "ne | n"),
    **phrases(Word(Kind.NOT), "sans | au lieu de | au lieu d"),
    **phrases(Word(Kind.POSSIBLE), "peux | pourrais"),
    **phrases(Word(Kind.EXAMPLE), "exemple | exemples | par exemple"),
    **phrases(Word(Kind.JOIN), "et | puis | et puis | ensuite | mais | donc | alors | c'est pourquoi"),
    **phrases(Word(Kind.OR), "ou"),
    **phrases(Word(Kind.SMALL), "un peu | légèrement"),
    **phrases(Word(Kind.ARTICLE), "une"),
    **phrases(Word(Kind.OF), "de | du | d | des"),
    **phrases(Word(Kind.FRESH), "je | j | je vais | je dois | je veux | il faut | nous"),
    **phrases(Word(Kind.FILLER), "d'abord | me | m | mon | ma | le | environ | encore | maintenant que"),
    **phrases(Word(Kind.CLOSE), "vers la | vers le | le long de | le long du | dans le | dans la"),
    **phrases(Word(Kind.CONDITION), "si | quand | lorsque | parce que | avant de | avant d | jusqu'à ce que"),
    **phrases(_STEPS, "pas de plus"),
    **numbers("deux=2 trois=3 quatre=4 cinq=5 dix=10 demi=0.5 trente=30 quarante=40"),
}
