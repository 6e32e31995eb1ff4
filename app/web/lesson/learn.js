// @ts-check
// All lessons: how long each takes, what goes well before it, and where one left off.

import { send } from "../player/pipe.js";
import { element, write } from "../time/dom.js";
import { closeList } from "./outer.js";
import { changed, lessonShown, state, whenChanged } from "./state.js";
import { setLanguage, word } from "./words.js";

/** @typedef {import("./state.js").Listed} Listed */

const page = element("div", "learn");
page.innerHTML = `
  <header>
    <h1 tabindex="-1"></h1>
    <button type="button" class="quiet close"></button>
  </header>
  <main>
    <p class="about"></p>
    <p class="fault" role="alert"></p>
    <ol></ol>
    <label class="file quiet"><span></span><input type="file" accept=".yaml,.yml" class="unseen" /></label>
    <button type="button" class="quiet leave"></button>
  </main>`;
const part = (/** @type {string} */ name) => /** @type {HTMLElement} */ (page.querySelector(name));
const list = part("ol");
document.body.append(page);

/** What the browser speaks, where a lesson does. */
const SPOKEN = navigator.languages.map((each) => each.split("-")[0]);
/** @param {Listed} listed */
const languageFor = ({ languages }) =>
  state.told?.lesson?.language ?? SPOKEN.find((each) => languages.includes(each)) ?? null;

/** @param {Listed} listed @param {boolean} again */
const start = (listed, again) => {
  state.listing = false;
  const isSpoken = listed.languages.includes(languageFor(listed) ?? "");
  send({ do: "start", name: listed.name, language: isSpoken ? languageFor(listed) : null, again });
  changed();
};

/** A file is sent in parts, for no message is longer than a few thousand bytes. */
const PART = 1_200;
const MOST_PARTS = 64;

/** @param {File} file */
const upload = async (file) => {
  const text = (await file.text()).slice(0, PART * MOST_PARTS + 1);
  const parts = Math.max(Math.ceil(text.length / PART), 1);
  // What is too large is told to be, by the last part that is allowed.
  for (let part = 0; part < Math.min(parts, MOST_PARTS); part++)
    send({ do: "upload", name: file.name.slice(0, 200), part, parts: Math.min(parts, MOST_PARTS), text: text.slice(part * PART, (part + 1) * PART) });
};

/** @param {string} text @param {string} kind @param {string} title @param {() => void} act */
const button = (text, kind, title, act) => {
  const made = element("button", kind, text);
  made.setAttribute("type", "button");
  // One of several of the same name says of which lesson it is.
  made.ariaLabel = `${text}: ${title}`;
  made.addEventListener("click", act);
  return made;
};

/** In the language that the list is in, if the lesson has it. @param {Listed["titles"]} titles */
const titleOf = (titles) => titles[document.documentElement.lang] ?? Object.values(titles)[0];

/** @param {Listed} listed */
const item = (listed) => {
  const { name, titles, minutes, needs, languages, at, n } = listed;
  const title = titleOf(titles);
  const made = element("li", "");
  const about = [word("minutes", minutes), word("cardsOf", n), ...(languages.length > 1 ? [languages.map(word).join(", ")] : [])];
  made.append(element("h2", "", title), element("p", "facts", about.join(" · ")));
  if (needs.length) made.append(element("p", "needs", word("needs", needs.map(titleOf).join(", "))));
  const ways = element("div", "ways");
  if (state.told?.lesson?.name === name) {
    const back = button(word("here"), "primary", title, () => {
      state.listing = false;
      changed();
    });
    ways.append(back, button(word("again"), "quiet", title, () => start(listed, true)));
  } else if (at === null) ways.append(button(word("start"), "primary", title, () => start(listed, true)));
  else
    ways.append(
      button(word("goOn", at + 1), "primary", title, () => start(listed, false)),
      button(word("again"), "quiet", title, () => start(listed, true)),
    );
  made.append(ways);
  return made;
};

let key = "";
let isShown = false;

whenChanged(() => {
  const { told } = state;
  const wasShown = isShown;
  isShown = told !== null && !lessonShown() && !told.free;
  page.hidden = !isShown;
  if (!told || !isShown) return;
  if (!told.lesson) setLanguage(SPOKEN.find((each) => told.list.some(({ languages }) => languages.includes(each))) ?? "en");
  write(part("h1"), word("lessons"));
  write(part(".close"), word(told.lesson ? "back" : "close"));
  write(part(".about"), told.list.length ? word("learn") : word("noLessons"));
  write(part(".fault"), told.fault ?? "");
  write(part(".file span"), word("add"));
  part(".leave").hidden = !told.lesson;
  write(part(".leave"), word("leave"));
  const now = JSON.stringify([told.list, told.lesson?.name, document.documentElement.lang]);
  if (now !== key) {
    key = now;
    list.replaceChildren(...told.list.map(item));
  }
  if (!wasShown) part("h1").focus({ preventScroll: true });
});

part(".close").addEventListener("click", () => {
  if (!state.told?.lesson) return closeList();
  state.listing = false;
  changed();
});
const file = /** @type {HTMLInputElement} */ (part(".file input"));
file.addEventListener("change", () => {
  const [chosen] = file.files ?? [];
  if (chosen) void upload(chosen);
  // The same one may be chosen again, once it has been mended.
  file.value = "";
});
part(".leave").addEventListener("click", () => {
  state.listing = false;
  send({ do: "leave" });
});
