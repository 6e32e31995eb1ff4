// @ts-check
// What the lab's page has beside viser's.
import "./connection.js";
import "./title.js";
