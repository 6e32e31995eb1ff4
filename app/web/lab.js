// @ts-check
// What the lab's page has beside viser's.
import "./connection.js";
import "./docks.js";
import "./drawn.js";
import "./fields.js";
import "./frame.js";
import "./hints.js";
import "./keys.js";
import "./names.js";
import "./scheme.js";
import "./slots.js";
import "./stage.js";
import "./tabs.js";
import "./terms.js";
import "./tips.js";
import "./title.js";
import "./tour.js";
