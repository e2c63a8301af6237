"""What German, Spanish and French tell instead of asking: the past, others, purposes, what is put off."""

from __future__ import annotations

from foundry.worlds.camera.language.vocabulary.words import Act, Form, Kind, Side, Table, Way, Word, phrases

_PERFECT = Word(Kind.VERB, act=Act.MOVE, form=Form.PAST, side=Side.BEFORE)


def _past(act: Act, text: str, *ways: Way) -> dict[str, Word]:
    return phrases(Word(Kind.VERB, act=act, form=Form.PAST, ways=ways), text)


GERMAN_TOLD: Table = {
    **phrases(
        _PERFECT,
        "gegangen | gelaufen | bewegt | gefahren | geschwebt | getreten | vorgerückt | zurückgegangen | "
        "zurückgetreten | "
        "vorgegangen | gedreht | gewendet | geschwenkt | abgebogen | umgedreht | geschaut | geblickt | gesenkt | "
        "gehoben | geneigt | gerichtet",
    ),
    **_past(Act.MOVE, "ging | lief | bewegte | fuhr | schwebte | trat | machte"),
    **_past(Act.TURN, "drehte | rotierte | wendete | wandte | schwenkte | bog"),
    **_past(Act.LOOK, "schaute | blickte | senkte | hob | neigte | sah"),
    **phrases(Word(Kind.IS, form=Form.PAST), "war | waren | hatte | wurde | habe | bin"),
    **phrases(Word(Kind.PAST), "versuchte | wollte | versucht habe | mein versuch"),
    **phrases(
        Word(Kind.EARLIER),
        "im letzten schritt | im vorigen schritt | im vorherigen schritt | im vorangegangenen schritt | zuletzt | "
        "zuvor | "
        "vorhin | eben | gerade eben | soeben | bisher | letztes mal | beim letzten mal | letzte bewegung | "
        "vorige bewegung | vorherige bewegung | letzte aktion | vorherige aktion | letzte antwort | "
        "vorherige antwort | "
        "im schritt davor | letzte drehung | sagte ich | ich sagte | letzter schritt | letzten schritten | früher",
    ),
    **phrases(
        Word(Kind.NOW),
        "jetzt | nun | diesmal | nächste bewegung | meine nächste bewegung | in diesem schritt | dieses mal | "
        "nächste aktion | meine bewegung | für diesen schritt",
    ),
    **phrases(
        Word(Kind.LATER),
        "später | beim nächsten mal | nächstes mal | irgendwann | erst danach | erst dann | erst wenn | "
        "in einem späteren schritt | im übernächsten schritt | das nächste mal",
    ),
    **phrases(
        Word(Kind.NEXT),
        "im nächsten schritt | im nächsten zug | im folgenden schritt | in der nächsten runde | als nächstes erst",
    ),
    **phrases(
        Word(Kind.FIRST),
        "aber zuerst | doch zuerst | aber vorher | doch vorher | vorher aber | zuerst aber | aber zunächst | "
        "doch zunächst | vorher | aber erst | zuvor aber",
    ),
    **phrases(
        Word(Kind.RETRACT),
        "nein, | nein, moment | halt, | korrektur | doch lieber | vielmehr | moment, | besser gesagt | ich meine | "
        "lieber doch | nein.",
    ),
    **phrases(
        Word(Kind.OTHER),
        "roboter | person | mann | frau | astronautin | mensch | jemand | er | mitarbeiter | figur | agenten | "
        "wissenschaftler",
    ),
    **phrases(Word(Kind.OTHER, scale=True), "personen | leute | menschen | astronauten | männer | frauen"),
    **phrases(Word(Kind.GOAL), "ziel | aufgabe | auftrag | zweck"),
    **phrases(Word(Kind.PURPOSE), "damit | zum zweck"),
}

SPANISH_TOLD: Table = {
    **_past(Act.MOVE, "avancé | avanzado | avanzó | avanzaba | avanzamos", Way.FORWARD),
    **_past(Act.MOVE, "retrocedí | retrocedido | retrocedió | retrocedía", Way.BACK),
    **_past(
        Act.MOVE, "me moví | movido | se movió | caminé | caminado | caminó | caminaba | me desplacé | desplazado | di"
    ),
    **_past(Act.TURN, "giré | girado | giró | giraba | roté | rotado | rotó | me giré | volteé | doblé"),
    **_past(Act.LOOK, "miré | mirado | miró | miraba | bajé | bajado | levanté | levantado | subí | incliné"),
    **phrases(Word(Kind.IS, form=Form.PAST), "fue | fui | era | estaba | había | hubo | choqué | estuve"),
    **phrases(Word(Kind.PAST), "intenté | traté de | quise | mi intento de | he intentado | iba a | intentaba"),
    **phrases(
        Word(Kind.EARLIER),
        "en el paso anterior | en el último paso | en mi último paso | en el turno anterior | anteriormente | "
        "la última vez | último movimiento | movimiento anterior | hace un momento | previamente | hasta ahora | "
        "última respuesta | respuesta anterior | acción anterior | última acción | antes | dije | paso anterior | "
        "en los pasos anteriores | último giro | giro anterior | último paso",
    ),
    **phrases(Word(Kind.AFTER), "después de | tras | luego de"),
    **phrases(
        Word(Kind.NOW),
        "ahora | esta vez | por ahora | en este paso | mi próximo movimiento | próximo movimiento | "
        "siguiente movimiento | "
        "mi siguiente movimiento | mi movimiento | próxima acción | mi decisión",
    ),
    **phrases(
        Word(Kind.LATER),
        "más tarde | más adelante | la próxima vez | después de esto | después de eso | luego de esto | "
        "en un paso posterior | próxima vez | en otro paso | eventualmente",
    ),
    **phrases(
        Word(Kind.NEXT),
        "en el próximo paso | en el siguiente paso | en el paso siguiente | en el próximo turno | "
        "en el próximo movimiento | "
        "en la próxima acción | en la siguiente acción | en el siguiente movimiento",
    ),
    **phrases(Word(Kind.FIRST), "pero primero | pero antes | aunque primero | pero antes de eso"),
    **phrases(
        Word(Kind.RETRACT),
        "no, espera | espera, | mejor dicho | corrección | perdón, | mejor: | quiero decir | en realidad, | no, mejor",
    ),
    **phrases(
        Word(Kind.OTHER),
        "agente | persona | hombre | mujer | astronauta | él | ella | alguien | niño | trabajador | figura",
    ),
    **phrases(Word(Kind.OTHER, scale=True), "personas | hombres | mujeres | astronautas"),
    **phrases(Word(Kind.GOAL), "objetivo | meta | tarea | misión | propósito"),
    **phrases(
        Word(Kind.PURPOSE), "para | para poder | con el fin de | a fin de | con el objetivo de | permite | permitirá"
    ),
}

FRENCH_TOLD: Table = {
    **_past(Act.MOVE, "avancé | avançais | avançait | avança", Way.FORWARD),
    **_past(Act.MOVE, "reculé | reculais | reculait | recula", Way.BACK),
    **_past(Act.MOVE, "bougé | déplacé | marché | marchais | marchait | allé | allée | suis allé"),
    **_past(Act.TURN, "tourné | tournais | tournait | tourna | pivoté | pivotais | effectué"),
    **_past(Act.LOOK, "regardé | regardais | regardait | baissé | levé | relevé | incliné"),
    **phrases(Word(Kind.IS, form=Form.PAST), "était | étais | avait | avais | fut | ai été | a été | suis"),
    **phrases(Word(Kind.PAST), "essayé de | essayé d | tenté de | tenté d | voulu | ma tentative de | ma tentative d"),
    **phrases(
        Word(Kind.EARLIER),
        "à l'étape précédente | à la dernière étape | précédemment | tout à l'heure | auparavant | la dernière fois | "
        "dernier mouvement | mouvement précédent | dernière réponse | réponse précédente | jusqu'ici | "
        "au pas précédent | "
        "lors de la dernière étape | lors de l'étape précédente | à l'instant | au dernier pas | dernière action | "
        "action précédente | étape précédente | dernière rotation | dernière étape",
    ),
    **phrases(Word(Kind.AFTER), "après | après avoir"),
    **phrases(
        Word(Kind.NOW),
        "maintenant | cette fois | à présent | mon prochain mouvement | prochain mouvement | pour cette étape | "
        "ma prochaine action | prochaine action | pour l'instant | mon mouvement",
    ),
    **phrases(
        Word(Kind.LATER),
        "plus tard | la prochaine fois | après cela | par la suite | ultérieurement | après ça | "
        "dans une étape ultérieure",
    ),
    **phrases(
        Word(Kind.NEXT),
        "à l'étape suivante | à la prochaine étape | au prochain pas | dans la prochaine étape | au pas suivant | "
        "au prochain tour | lors de la prochaine étape | au tour suivant",
    ),
    **phrases(Word(Kind.FIRST), "mais d'abord | mais avant | mais auparavant | mais avant cela"),
    **phrases(
        Word(Kind.RETRACT),
        "non, | non, attends | attends, | pardon, | je veux dire | en fait, | non, plutôt | ou plutôt | rectification",
    ),
    **phrases(Word(Kind.FILLER), "plutôt"),
    **phrases(
        Word(Kind.OTHER),
        "personne | homme | femme | astronaute | quelqu'un | il | elle | individu | personnage | enfant",
    ),
    **phrases(Word(Kind.OTHER, scale=True), "personnes | hommes | femmes | astronautes | ils | elles"),
    **phrases(Word(Kind.GOAL), "objectif | le but | mon but | tâche"),
    **phrases(
        Word(Kind.PURPOSE), "pour | pour que | pour pouvoir | afin de | afin d | afin que | permet de | permettra de"
    ),
    **phrases(Word(Kind.CLOSE), "qui"),
}
