// @ts-check
// What the page of a class says of itself, in the language of the lesson.

import { phrase } from "../time/words.js";

/** @type {Record<string, Record<string, string>>} */
const WORDS = {
  en: {
    seat: "Your seat:",
    circle: "circle",
    triangle: "triangle",
    square: "square",
    star: "star",
    diamond: "diamond",
    cross: "cross",
    card: "{0}: card {1} of {2}",
    waiting: "Questions come here. Look at the board until then.",
    ended: "The class has ended, and all that it answered is forgotten.",
    noSeat: "This page has no seat, so it only looks: it needs its cookie, and a seat that is free.",
    takeSeat: "Take a seat",
    choose: "Choose your answer.",
    chooseSeveral: "Touch all parts round the prey that you mean.",
    again: "Second vote. Talk with somebody whose shape is another, and answer once more.",
    sent: "Your answer counts. You may change it as long as the question is open.",
    waits: "Your answer waits for a connection.",
    late: "The question was closed before you answered.",
    few: "Fewer than five have answered, so nobody's answers are shown.",
    trial: "trial",
  },
  de: {
    seat: "Dein Platz:",
    circle: "Kreis",
    triangle: "Dreieck",
    square: "Quadrat",
    star: "Stern",
    diamond: "Raute",
    cross: "Kreuz",
    card: "{0}: Karte {1} von {2}",
    waiting: "Fragen kommen hierher. Schau bis dahin auf das Feld.",
    ended: "Die Klasse ist zu Ende, und alle Antworten sind vergessen.",
    noSeat: "Diese Seite hat keinen Platz und schaut nur zu: Sie braucht ihren Cookie und einen freien Platz.",
    takeSeat: "Platz nehmen",
    choose: "Wähle deine Antwort.",
    chooseSeveral: "Berühre alle Teile um die Beute, die du meinst.",
    again: "Zweite Abstimmung. Sprich mit jemandem, der eine andere Form hat, und antworte noch einmal.",
    sent: "Deine Antwort zählt. Du kannst sie ändern, solange die Frage offen ist.",
    waits: "Deine Antwort wartet auf eine Verbindung.",
    late: "Die Frage war zu, bevor du geantwortet hast.",
    few: "Weniger als fünf haben geantwortet, also wird keine Antwort gezeigt.",
    trial: "Versuch",
  },
};

/**
 * @param {string} key
 * @param {...unknown} parts what stands in the places of {0}, {1}, ...
 */
export const word = (key, ...parts) => phrase(WORDS, document.documentElement.lang, key, parts);
