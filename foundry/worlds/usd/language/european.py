"""The basic words of German, Spanish and French."""

from __future__ import annotations

from foundry.worlds.usd.language.words import Act, Dimension, Kind, Side, Table, Way, Word, numbers, phrases

_METRE = Word(Kind.UNIT, dimension=Dimension.LENGTH, number=1.0)
_CENTIMETRE = Word(Kind.UNIT, dimension=Dimension.LENGTH, number=0.01)
_STEPS = Word(Kind.UNIT, dimension=Dimension.STEP, number=1.0)
_DEGREE = Word(Kind.UNIT, dimension=Dimension.ANGLE, number=1.0)
_FORWARD, _BACK = Word(Kind.WAY, ways=(Way.FORWARD,)), Word(Kind.WAY, ways=(Way.BACK,))
_LEFT, _RIGHT = Word(Kind.WAY, ways=(Way.LEFT,)), Word(Kind.WAY, ways=(Way.RIGHT,))
_UP, _DOWN = Word(Kind.WAY, ways=(Way.UP,)), Word(Kind.WAY, ways=(Way.DOWN,))
_MOVE, _TURN, _LOOK = (Word(Kind.VERB, act=act, goes=True) for act in (Act.MOVE, Act.TURN, Act.LOOK))
_AROUND = Word(Kind.VERB, act=Act.TURN, ways=(Way.AROUND,), number=180.0)

GERMAN: Table = {
    **phrases(_MOVE, "gehe | geh | laufe | lauf | bewege | beweg | fahre | schwebe"),
    **phrases(
        Word(Kind.VERB, act=Act.MOVE, side=Side.BEFORE, goes=True), "gehen | laufen | bewegen | fahren | schweben"
    ),
    **phrases(_TURN, "drehe | dreh | rotiere"),
    **phrases(Word(Kind.VERB, act=Act.TURN, side=Side.BEFORE), "drehen | rotieren"),
    **phrases(_AROUND, "umdrehen | drehe mich um | dreh dich um | drehe dich um | kehre um"),
    **phrases(Word(Kind.FILLER), "drehe mich um meine achse | mich | dich | meinen körper | den körper"),
    **phrases(_LOOK, "schaue | schau | blicke | blick | sieh"),
    **phrases(Word(Kind.VERB, act=Act.LOOK, side=Side.BEFORE), "schauen | blicken"),
    **phrases(_FORWARD, "vorwärts | nach vorne | nach vorn | geradeaus | vor"),
    **phrases(_BACK, "rückwärts | zurück | nach hinten"),
    **phrases(_LEFT, "links | nach links"),
    **phrases(_RIGHT, "rechts | nach rechts"),
    **phrases(_UP, "nach oben"),
    **phrases(_DOWN, "nach unten"),
    **phrases(_CENTIMETRE, "zentimeter"),
    **phrases(_STEPS, "schritt | schritte"),
    **phrases(_DEGREE, "grad"),
    **phrases(Word(Kind.STAY), "bleibe stehen | bleib stehen | stehen bleiben | bleibe hier | bleib hier"),
    **phrases(Word(Kind.PAUSE), "warte | warten | bleibe | bleib"),
    **phrases(Word(Kind.NOT, reach="both", decides=True), "nicht"),
    **phrases(Word(Kind.NOT), "ohne | statt | anstatt"),
    **phrases(Word(Kind.POSSIBLE), "kann | könnte | vielleicht"),
    **phrases(Word(Kind.CONDITION), "wenn | falls | weil | bevor | ob"),
    **phrases(Word(Kind.EXAMPLE), "beispiel | beispiele | zum beispiel"),
    **phrases(Word(Kind.JOIN), "und | dann | sondern | aber"),
    **phrases(Word(Kind.OR), "oder"),
    **phrases(Word(Kind.FRESH), "ich | werde | ich werde | stattdessen"),
    **phrases(Word(Kind.BY), "um | etwa | ungefähr"),
    **phrases(Word(Kind.SMALL), "ein bisschen | ein wenig | leicht | etwas"),
    **phrases(Word(Kind.ARTICLE), "ein | eine | einen"),
    **phrases(Word(Kind.CLOSE), "zur | zum | zu | auf der | durch | rechts von | links von"),
    **numbers("eins=1 zwei=2 drei=3 vier=4 fünf=5 sechs=6 zehn=10 fünfzehn=15 zwanzig=20 dreißig=30 halb=0.5 "),
    **numbers("halben=0.5 halber=0.5 halbe=0.5 anderthalb=1.5 neunzig=90 fünfundvierzig=45 sechzig=60"),
}

SPANISH: Table = {
    **phrases(Word(Kind.VERB, act=Act.MOVE, ways=(Way.FORWARD,)), "avanza | avanzar | avanzo | avanzaré | avanzando"),
    **phrases(Word(Kind.VERB, act=Act.MOVE, ways=(Way.BACK,)), "retrocede | retroceder | retrocedo | retrocederé"),
    **phrases(_MOVE, "muévete | mueve | mover | moverme | me muevo | me moveré | camina | caminar | camino | caminaré"),
    **phrases(_TURN, "gira | girar | giro | giraré | gire | girando | rota | rotar"),
    **phrases(_AROUND, "da la vuelta | date la vuelta | media vuelta | dar la vuelta | darme la vuelta"),
    **phrases(_LOOK, "mira | mirar | miro | miraré"),
    **phrases(_FORWARD, "adelante | hacia adelante | hacia delante | recto"),
    **phrases(_BACK, "atrás | hacia atrás"),
    **phrases(_LEFT, "izquierda | a la izquierda | hacia la izquierda"),
    **phrases(_RIGHT, "derecha | a la derecha | hacia la derecha"),
    **phrases(_UP, "arriba | hacia arriba"),
    **phrases(_DOWN, "abajo | hacia abajo"),
    **phrases(_METRE, "metro | metros"),
    **phrases(_CENTIMETRE, "centímetro | centímetros"),
    **phrases(_STEPS, "paso | pasos"),
    **phrases(_DEGREE, "grado | grados"),
    **phrases(Word(Kind.STAY), "no te muevas | quédate | quedarme | me quedo | me quedaré | quedarse"),
    **phrases(Word(Kind.PLACE), "quieto | quieta | aquí"),
    **phrases(
        Word(Kind.NOT),
        "no avances | no avanzar | no gires | no girar | no voy a | no debo | no puedo | sin",
    ),
    **phrases(Word(Kind.POSSIBLE), "puedo | podría"),
    **phrases(Word(Kind.EXAMPLE), "ejemplo | ejemplos | por ejemplo"),
    **phrases(Word(Kind.JOIN), "y | luego | y luego | pero | después"),
    **phrases(Word(Kind.OR), "o"),
    **phrases(Word(Kind.SMALL), "un poco | ligeramente"),
    **phrases(Word(Kind.ARTICLE), "un | una | uno"),
    **phrases(Word(Kind.FRESH), "voy a"),
    **numbers("dos=2 tres=3 cuatro=4 cinco=5 diez=10 medio=0.5 treinta=30 noventa=90 cuarenta=40"),
}

FRENCH: Table = {
    **phrases(Word(Kind.VERB, act=Act.MOVE, ways=(Way.FORWARD,)), "avance | avancer | avancez | avancerai"),
    **phrases(Word(Kind.VERB, act=Act.MOVE, ways=(Way.BACK,)), "recule | reculer | reculez | reculerai"),
    **phrases(_MOVE, "bouge | bouger | déplace | déplacer | marche | marcher"),
    **phrases(_TURN, "tourne | tourner | tournez | tournerai | pivote | pivoter"),
    **phrases(_AROUND, "fais demi tour | faire demi tour | demi tour"),
    **phrases(_LOOK, "regarde | regarder | regardez"),
    **phrases(_FORWARD, "tout droit | en avant | vers l'avant"),
    **phrases(_BACK, "en arrière | vers l'arrière"),
    **phrases(_LEFT, "gauche | à gauche | vers la gauche | sur la gauche"),
    **phrases(_RIGHT, "droite | à droite | vers la droite | sur la droite"),
    **phrases(_UP, "en haut | vers le haut"),
    **phrases(_DOWN, "en bas | vers le bas"),
    **phrases(_METRE, "mètre | mètres"),
    **phrases(_CENTIMETRE, "centimètre | centimètres"),
    **phrases(_DEGREE, "degré | degrés"),
    **phrases(Word(Kind.STAY), "reste | rester | restez"),
    **phrases(Word(Kind.PLACE), "ici | sur place | immobile"),
    **phrases(Word(Kind.NOT, reach="both", decides=True), "pas"),
    **phrases(Word(Kind.NOT, decides=True), "ne | n"),
    **phrases(Word(Kind.NOT), "sans | au lieu de"),
    **phrases(Word(Kind.POSSIBLE), "peux | pourrais"),
    **phrases(Word(Kind.EXAMPLE), "exemple | exemples | par exemple"),
    **phrases(Word(Kind.JOIN), "et | puis | et puis | ensuite | mais"),
    **phrases(Word(Kind.OR), "ou"),
    **phrases(Word(Kind.SMALL), "un peu | légèrement"),
    **phrases(Word(Kind.ARTICLE), "une"),
    **phrases(Word(Kind.OF), "de | du | d | des"),
    **phrases(Word(Kind.FRESH), "je | je vais"),
    **numbers("deux=2 trois=3 quatre=4 cinq=5 dix=10 demi=0.5 trente=30 quarante=40"),
}
