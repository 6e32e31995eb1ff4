// @ts-check
// What the lab's page has beside viser's.
import "./connection.js";
import "./fields.js";
import "./keys.js";
import "./names.js";
import "./slots.js";
import "./stage.js";
import "./tabs.js";
import "./terms.js";
import "./title.js";
import "./windows.js";
