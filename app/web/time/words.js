// @ts-check
// What is said on the bar of what a lesson asks there, in the language of that lesson; all else on the bar
// is as the page has it.

/** @type {Record<string, Record<string, string>>} */
const WORDS = {
  en: {
    flag: "Your guess: at which trial",
    curve: "Your curve: six points",
    yours: "your guess: {0}",
    noneYet: "no guess yet",
    trial: "trial {0}",
    runAt: "this run: {0}",
    when: "When will it be? Click on the bar, or move the flag with the arrow keys.",
    noGuess: "You gave no guess",
    guess: "Your guess: trial {0}",
    movable: "It can be moved until you commit.",
    run: "This run: trial {0}",
    runs: "{0} runs: trial {1} to {2}",
    someRuns: "{0} of {1} runs: trial {2} to {3}",
    rewardAt: "Reward at trial {0}",
    reward: "reward {0}",
    how: "How will reward go from trial {0} to {1}? Drag the six points, or draw across them.",
    drawn: "Your guess",
    notDrawn: "You drew nothing",
    changeable: "It can be changed until you commit.",
    thisRun: "This run",
    band: "Where twenty runs went",
  },
  de: {
    flag: "Dein Tipp: bei welchem Versuch",
    curve: "Deine Kurve: sechs Punkte",
    yours: "dein Tipp: {0}",
    noneYet: "noch kein Tipp",
    trial: "Versuch {0}",
    runAt: "dieser Lauf: {0}",
    when: "Wann wird es so weit sein? Klicke auf die Leiste oder bewege die Fahne mit den Pfeiltasten.",
    noGuess: "Du hast nicht getippt",
    guess: "Dein Tipp: Versuch {0}",
    movable: "Du kannst ihn verschieben, bis du dich festlegst.",
    run: "Dieser Lauf: Versuch {0}",
    runs: "{0} Läufe: Versuch {1} bis {2}",
    someRuns: "{0} von {1} Läufen: Versuch {2} bis {3}",
    rewardAt: "Belohnung bei Versuch {0}",
    reward: "Belohnung {0}",
    how: "Wie verläuft die Belohnung von Versuch {0} bis {1}? Ziehe die sechs Punkte oder zeichne über sie hinweg.",
    drawn: "Dein Tipp",
    notDrawn: "Du hast nichts gezeichnet",
    changeable: "Du kannst ihn ändern, bis du dich festlegst.",
    thisRun: "Dieser Lauf",
    band: "Wo zwanzig Läufe waren",
  },
};

/** German has no sign between the thousands of four digits, and no point, which is read as a decimal one. */
const GROUPED = { en: { from: 1_000, by: ",", point: "." }, de: { from: 10_000, by: "\u202f", point: "," } };

/**
 * A number as it is written in a language, as `app/lessons/words.py` has it; in English where it is none of these.
 * @param {string} language
 * @param {number} number
 * @param {number} [digits] behind the point
 */
export const numeralIn = (language, number, digits = 0) => {
  const { from, by, point } = GROUPED[/** @type {keyof GROUPED} */ (language)] ?? GROUPED.en;
  const useGrouping = Math.abs(number) >= from;
  const [whole, decimals] = number
    .toLocaleString("en-US", { maximumFractionDigits: digits, useGrouping })
    .replace("-", "\u2212")
    .split(".");
  return whole.replaceAll(",", by) + (decimals ? point + decimals : "");
};

/**
 * A phrase of a table in a language, in English where it has none of it.
 * @param {Record<string, Record<string, string>>} words
 * @param {string} language
 * @param {string} key
 * @param {unknown[]} parts what stands in the places of {0}, {1}, ...
 */
export const phrase = (words, language, key, parts) => {
  const text = words[language]?.[key] ?? words.en[key] ?? key;
  return text.replace(/\{(\d)\}/g, (_, place) => `${parts[Number(place)]}`);
};

/**
 * What is said on the bar of a question; numbers are written as in its language.
 * @param {{language: string}} asked
 * @param {string} key
 * @param {...number | string} parts
 */
export const wordOf = ({ language }, key, ...parts) =>
  phrase(
    WORDS,
    language,
    key,
    parts.map((part) => (typeof part === "number" ? numeralIn(language, Math.round(part)) : part)),
  );
