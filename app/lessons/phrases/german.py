"""German, with numbers as the shipped lessons write them: 2000, 12 000 and 0,9."""

from typing import Final

from app.lessons.phrases.language import Language

GERMAN: Final = Language(
    thousands="\N{NARROW NO-BREAK SPACE}",
    grouped_from=10_000,
    point=",",
    percent="\N{NO-BREAK SPACE}%",
    phrases={
        "and": "und",
        "trial": "Versuch {trial}",
        "runs.one": "{n} Lauf",
        "runs.more": "{n} Läufe",
        "in_of.one": "in {k} von {n} Lauf",
        "in_of.more": "in {k} von {n} Läufen",
        # Octants.
        "octant.e": "vorn",
        "octant.ne": "vorn links",
        "octant.n": "linke Seite",
        "octant.nw": "hinten links",
        "octant.w": "hinten",
        "octant.sw": "hinten rechts",
        "octant.s": "rechte Seite",
        "octant.se": "vorn rechts",
        # The board.
        "board.k_of_n": "{k} von {n}",
        "board.guess": "umrandet: dein Tipp",
        "board.numbers": "Zahlen: von {n} Läufen",
        "board.run": "blau: dieser Lauf",
        "board.class": "orange: die Klasse",
        # What the card waits for.
        "busy.other_run": "Auf dem Feld ist ein anderer Lauf als der dieser Lektion.",
        "busy.before": (
            "Das ist der Moment davor. Was du hier tust, ergibt einen Zweig, und mit dem geht die"
            " Lektion weiter."
        ),
        "busy.start": (
            "Er lernt bis Versuch {start}, dort geht es los; jetzt ist er in Versuch {trial} …"
        ),
        "busy.learns": "Er lernt weiter bis Versuch {until} und ist jetzt in Versuch {trial} …",
        "busy.catches.one": "Es geht Versuch für Versuch weiter, noch {n} Fang …",
        "busy.catches.more": "Es geht Versuch für Versuch weiter, noch {n} Fänge …",
        "busy.experiment": "Das Experiment beginnt …",
        "busy.experiment_runs.one": "{done} von {n} Lauf ist gerechnet …",
        "busy.experiment_runs.more": "{done} von {n} Läufen sind gerechnet …",
        # What became of it.
        "check.done": "Geschafft.",
        "check.yes": "Ja, in Versuch {trial}.",
        "check.never": "In diesem Lauf kann das nicht mehr eintreten.",
        "check.not_yet": "Noch nicht.",
        "check.until": "Noch nicht. Zeit ist bis Versuch {until}.",
        "reveal.ahead": "Was daraus wird, ist noch nicht bekannt: So weit ist der Lauf noch nicht.",
        "reveal.other_run": "Auf dem Feld ist noch der Lauf von vorhin.",
        "reveal.twenty": "Zum Vergleich werden zwanzig Läufe gerechnet, fertig sind davon {n} …",
        "score.no_answer": "Darauf hat kein Lauf eine Antwort.",
        "score.key": "Richtig ist: {what}.",
        "score.own": "In diesem Lauf: {what}.",
        "score.own_never": "In diesem Lauf ist es nicht eingetreten.",
        "score.all": "Insgesamt: {what}.",
        "score.range": "{low} bis {high}",
        "score.always": "immer",
        "score.spread": "{runs}: {what} ({range}).",
        "score.never.one": "In {k} von {n} Lauf ist es nie eingetreten.",
        "score.never.more": "In {k} von {n} Läufen ist es nie eingetreten.",
        "score.octants": "Alle Richtungen, in denen sich die Läufe einig sind, hast du richtig.",
        "score.missed.one": "Du hast {n} Richtung ausgelassen.",
        "score.missed.more": "Du hast {n} Richtungen ausgelassen.",
        "score.wrong.one": "{n} deiner Richtungen blieb leer.",
        "score.wrong.more": "{n} deiner Richtungen blieben leer.",
        "score.no_curve": "Die Kurve ist noch nicht bekannt.",
        "score.point.one": "{k} deiner {points} Punkte liegt im Bereich von {n} Lauf.",
        "score.point.more": "{k} deiner {points} Punkte liegt im Bereich von {n} Läufen.",
        "score.points.one": "{k} deiner {points} Punkte liegen im Bereich von {n} Lauf.",
        "score.points.more": "{k} deiner {points} Punkte liegen im Bereich von {n} Läufen.",
        "score.no_pairs": "Bei keinen zweien davon sind sich die Läufe einig.",
        "score.pairs.one": "Bei {n} Paar sind sich die Läufe einig, {k} davon hast du richtig.",
        "score.pairs.more": "Bei {n} Paaren sind sich die Läufe einig, {k} davon hast du richtig.",
        "sure": "Du warst dir zu {percent}\u00a0% sicher und lagst {k} von {n} Mal richtig.",
        # Controls.
        "control.play": "Lernen lassen",
        "control.pause": "Anhalten",
        "control.over": "Dieser Lauf hat alle seine Versuche hinter sich.",
        "control.run_to": "Lernen bis Versuch {trial}",
        "control.runs_to": "Auf dem Weg zu Versuch {trial} …",
        "control.is_there": "Dieser Versuch ist schon erreicht.",
        "control.on_its_way": "Er ist auf dem Weg dahin.",
        "control.step": "Ein Schritt",
        "control.trial": "Ein Versuch",
        "control.speed": "Tempo",
        "control.speed_of": "{n} Schritte/s",
        "control.add_skill": "{skill} jetzt hinzufügen",
        "control.explore": "{skill} erkunden: {trials} Versuche mit {chance}",
        "control.stop_exploring": "{skill} nicht mehr erkunden",
        "control.freeze_selection": "Auswahl einfrieren",
        "control.freeze_skills": "Fertigkeiten einfrieren",
        "control.plan": "Dem Plan folgen",
        "control.layer": "Ebene",
        "control.headings": "Blickrichtungen",
        "control.turned": "Alle in einem, Beute schaut nach rechts",
        "control.all": "Alle Blickrichtungen nebeneinander",
        "control.as_in_trial": "Wie im laufenden Versuch",
        "control.side": "Läufe nebeneinander",
        "control.watch": "Bei einer Jagd zusehen",
        "control.experiment": "Experiment {name} starten",
        "control.undo": "Letzte Änderung zurücknehmen",
        "control.nothing_done": "Noch wurde nichts von Hand geändert.",
        "control.start_again": "Diesen Lauf neu beginnen",
        "control.back_to_run": "Zurück zum Lauf der Lektion",
        # What is said of the lesson's file, and of what could not be done.
        "news.changed": (
            "Die Datei dieser Lektion hat sich geändert, seit du angefangen hast. Du machst mit der"
            " Lektion weiter, wie sie war; von vorn ist es die neue."
        ),
        "news.gone": (
            "Die Datei dieser Lektion ist nicht mehr da oder nicht lesbar. Du machst mit der"
            " Lektion weiter, wie sie war, als du angefangen hast."
        ),
        "fault.unreadable": "Die Lektion dieser Sitzung kann dieses pounce nicht lesen.",
        "fault.no_lesson": "Diese Lektion gibt es hier nicht mehr",
        "fault.not_whole": "Die Datei ist nicht vollständig angekommen; wähle sie noch einmal",
        "fault.no_answer": "Deine Antwort kam nicht an; gib sie noch einmal und lege dich fest",
        "fault.too_large": "Die Datei ist zu groß; erlaubt sind höchstens {n} Byte",
        "fault.added": "„{title}“ steht jetzt in der Liste.",
        # The printed sheet.
        "sheet.say": "Lies",
        "sheet.ask": "Sag voraus",
        "sheet.do": "Tu es",
        "sheet.see": "Was siehst du?",
        "sheet.why": "Warum?",
        "sheet.transfer": "Und jetzt?",
        "sheet.free": "Probier es aus",
        "sheet.about": (
            "{minutes} Minuten, neben dem Feld. Preset {preset}, Seed {seed}, ab Versuch {trial}."
        ),
        "sheet.own_words": "Erkläre es in eigenen Worten, bevor du weitermachst.",
        "sheet.number_them": "Nummeriere sie, 1 für das Erste.",
        "sheet.shade": (
            "Die Beute ist in der Mitte und schaut nach rechts. Schraffiere die Richtungen."
        ),
        "sheet.mark": "Markiere den Versuch.",
        "sheet.draw": (
            "Zeichne die Belohnung pro Versuch (nach oben) über den Versuchen (nach rechts)."
        ),
        "sheet.sure": "Wie sicher bist du?",
        "sheet.board": (
            "Das Feld in Versuch {trial}. Hell ist nah an einem Fang, dunkel fern davon;"
            " Gepunktetes ist nur zum Teil bekannt, Graues nicht."
        ),
        "sheet.answers": "Antworten: {title}",
        "sheet.answers_of": (
            "Aus dem Lauf der Lektion, der Seed {seed} hat, und aus {n} Läufen, die sich durch ihre"
            " Seeds unterscheiden, also nur durch Glück. Wer im Bereich dieser Läufe liegt, liegt"
            " nicht falsch."
        ),
        "sheet.this_run": "Dieser Lauf",
        "sheet.in_runs": "In {k} von {n} Läufen",
        "sheet.from_to": "In {n} Läufen von {low} bis {high}, die Hälfte davon unter {median}.",
        "sheet.octants": "In wie vielen von {n} Läufen jede Richtung dabei ist:",
        "sheet.band": (
            "Die Linie ist dieser Lauf; das graue Band liegt zwischen dem niedrigsten und dem"
            " höchsten von {n} Läufen."
        ),
        "sheet.nothing": "keine",
        "sheet.note": "Für die Lehrkraft:",
    },
)
