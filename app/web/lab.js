// @ts-check
// What the lab's page has beside viser's.
import "./bar.js";
import "./connection.js";
import "./docks.js";
import "./drawn.js";
import "./fields.js";
import "./keys.js";
import "./names.js";
import "./results.js";
import "./scheme.js";
import "./slots.js";
import "./stage.js";
import "./terms.js";
import "./tips.js";
import "./title.js";
