// @ts-check
// The camera looks straight down on the board, which just fits the room that there is for it.
//
// What a person has done to the view is a zoom and a place, which hold when the room changes. A drag
// moves the board along, and nothing tilts it.

/** Part of the room that stays free on each side of the board. */
const MARGIN = 0.015;
/** How much nearer one can come. */
const MOST_ZOOM = 30;
const LOOK_MS = 150;
const CELLS = "/board/cells";
const BORDER = "/board/border";

/** Half of what there is of the board to both sides, and its middle.
 * @typedef {{width: number, height: number, x: number, y: number}} Extent */
/** @typedef {{x: number, y: number, z: number, clone: () => Vector, distanceTo: (other: Vector) => number}} Vector */

/** The camera's controls that have been set up. @type {any} */
let known = null;
/** Whose extent was found last, and what it is. @type {[unknown, Extent]} */
let measured = [null, { width: 0, height: 0, x: 0, y: 0 }];
/** What would show all of the board in the room as it was last. */
let fitted = 0;
/** @type {(isDefault: boolean) => void} */
let tell = () => {};

/** viser's own, once it has a picture. @returns {any} */
const viewer = () => /** @type {any} */ (window).__viserMutable;

/** What is within the border: one board, or all headings side by side. @returns {Extent} */
const extent = () => {
  /** @type {Float32Array | undefined} */
  const points =
    /** @type {any} */ (window).__viserSceneTree?.getState()[BORDER]?.message.props.points;
  if (points && measured[0] !== points) {
    const ends = [0, 1].map((axis) => {
      const along = points.filter((_, at) => at % 3 === axis);
      return [Math.min(...along), Math.max(...along)];
    });
    const [[west, east], [south, north]] = ends;
    const [width, height] = [(east - west) / 2, (north - south) / 2];
    const found = { width, height, x: west + width, y: south + height };
    const isSame = JSON.stringify(found) === JSON.stringify(measured[1]);
    measured = [points, isSame ? measured[1] : found];
  }
  return measured[1];
};

/** Where a point of the board is in the picture's own space. @returns {Vector | undefined} */
const placed = (/** @type {number} */ x, /** @type {number} */ y, /** @type {number} */ z) => {
  const { camera, nodeRefFromName } = viewer();
  return nodeRefFromName[CELLS]?.localToWorld(camera.position.clone().set(x, y, z));
};

const middle = () => placed(extent().x, extent().y, 0);

/** From how far away all of the board is seen. */
const fitting = () => {
  const { camera } = viewer();
  const { width, height } = extent();
  const most = Math.max(height, width / camera.aspect) * (1 + 2 * MARGIN);
  return most / Math.tan((camera.fov * Math.PI) / 360);
};

const isDefault = () => {
  const home = middle();
  if (!known || !home || !fitted) return true;
  const off = known.getTarget(home.clone()).distanceTo(home) / extent().height;
  return Math.abs(known.distance / fitted - 1) < 0.01 && off < 0.01;
};

/**
 * @param {Vector} target
 * @param {number} distance
 */
const look = (target, distance) => {
  const below = placed(0, 0, 0);
  const above = placed(0, 0, 1);
  if (!below || !above) return;
  const eye = target.clone();
  for (const axis of /** @type {const} */ (["x", "y", "z"]))
    eye[axis] += (above[axis] - below[axis]) * distance;
  known.setLookAt(eye.x, eye.y, eye.z, target.x, target.y, target.z, false);
  tell(isDefault());
};

/** All of the board, in the middle. */
export const resetView = () => {
  const home = known && middle();
  if (!home || !extent().height) return;
  fitted = fitting();
  look(home, fitted);
};

/** A zoom is one of what fits, so it is another distance in another room. */
const refit = () => {
  if (!fitted) return resetView();
  const zoom = fitted / known.distance;
  fitted = fitting();
  look(known.getTarget(viewer().camera.position.clone()), fitted / zoom);
};

const setUp = () => {
  const mutable = viewer();
  known = mutable.cameraControl;
  fitted = 0;
  known.mouseButtons.left = known.mouseButtons.right;
  known.touches.one = known.touches.three;
  known.dollyToCursor = true;
  known.addEventListener("update", () => tell(isDefault()));
  // viser puts its camera where the server has it first, whenever it connects.
  Object.defineProperty(mutable, "resetCameraPose", {
    configurable: true,
    get: () => resetView,
    set: () => {},
  });
};

/** What there was of the board when this was looked at last. */
let shown = extent();

/** Nothing tells, either, that another board has come: one that is wider, or a square again. */
setInterval(() => {
  if (known && extent() !== shown) resetView();
  shown = extent();
}, LOOK_MS);

/** What was asked for last, and whether it waits for the board. */
let asked = { width: 0, height: 0 };
let isWaiting = false;

/** Nothing in the page tells that the board has come. */
const aim = () => {
  isWaiting = false;
  const mutable = viewer();
  if (!mutable?.cameraControl || !extent().height || !placed(0, 0, 0)) {
    isWaiting = true;
    return void requestAnimationFrame(aim);
  }
  if (mutable.cameraControl !== known) setUp();
  // Ahead of viser, which learns of its canvas's size a frame later.
  mutable.syncCanvasSize?.(asked.width, asked.height);
  refit();
  known.minDistance = fitted / MOST_ZOOM;
};

/**
 * Look at the board as the room for it is now.
 * @param {number} width of the room, in pixels
 * @param {number} height
 */
export const fitCamera = (width, height) => {
  const isSame = width === asked.width && height === asked.height;
  asked = { width, height };
  if (!isWaiting && width && height && !(isSame && viewer()?.cameraControl === known)) aim();
};

/** @param {(isDefault: boolean) => void} told whenever the view is all of the board, or is not */
export const whenViewChanges = (told) => (tell = told);
