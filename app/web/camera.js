// @ts-check
// The camera looks straight down on the board, which just fits the room that there is for it.
//
// What a person has done to the view is a zoom and a place, which hold when the room changes. A drag
// moves the board along, and nothing tilts it.

/** Part of the room that stays free on each side of the board. */
const MARGIN = 0.015;
/** How much nearer one can come. */
const MOST_ZOOM = 30;
const CELLS = "/board/cells";
const BORDER = "/board/border";

/** @typedef {{width: number, height: number}} Half */
/** @typedef {{x: number, y: number, z: number, clone: () => Vector, distanceTo: (other: Vector) => number}} Vector */

/** The camera's controls that have been set up. @type {any} */
let known = null;
/** Whose corner was found last, and how far it lies from the middle. @type {[unknown, Half]} */
let corner = [null, { width: 0, height: 0 }];
/** What would show all of the board in the room as it was last. */
let fitted = 0;
/** @type {(isDefault: boolean) => void} */
let tell = () => {};

/** viser's own, once it has a picture. @returns {any} */
const viewer = () => /** @type {any} */ (window).__viserMutable;

/** Half of what the board's border takes: a square, or all headings side by side. @returns {Half} */
const half = () => {
  /** @type {Float32Array | undefined} */
  const points =
    /** @type {any} */ (window).__viserSceneTree?.getState()[BORDER]?.message.props.points;
  if (!points) return { width: 0, height: 0 };
  if (corner[0] !== points) {
    const farthest = (/** @type {number} */ axis) =>
      points.reduce((most, part, at) => (at % 3 === axis ? Math.max(most, Math.abs(part)) : most), 0);
    corner = [points, { width: farthest(0), height: farthest(1) }];
  }
  return corner[1];
};

/** Where a point of the board is in the picture's own space. @returns {Vector | undefined} */
const placed = (/** @type {number} */ x, /** @type {number} */ y, /** @type {number} */ z) => {
  const { camera, nodeRefFromName } = viewer();
  return nodeRefFromName[CELLS]?.localToWorld(camera.position.clone().set(x, y, z));
};

/** From how far away all of the board is seen. */
const fitting = () => {
  const { camera } = viewer();
  const { width, height } = half();
  const most = Math.max(height, width / camera.aspect) * (1 + 2 * MARGIN);
  return most / Math.tan((camera.fov * Math.PI) / 360);
};

const isDefault = () => {
  const middle = placed(0, 0, 0);
  if (!known || !middle || !fitted) return true;
  const off = known.getTarget(middle.clone()).distanceTo(middle) / half().height;
  return Math.abs(known.distance / fitted - 1) < 0.01 && off < 0.01;
};

/**
 * @param {Vector} target
 * @param {number} distance
 */
const look = (target, distance) => {
  const middle = placed(0, 0, 0);
  const above = placed(0, 0, 1);
  if (!middle || !above) return;
  const eye = target.clone();
  for (const axis of /** @type {const} */ (["x", "y", "z"]))
    eye[axis] += (above[axis] - middle[axis]) * distance;
  known.setLookAt(eye.x, eye.y, eye.z, target.x, target.y, target.z, false);
  tell(isDefault());
};

/** All of the board, in the middle. */
export const resetView = () => {
  const middle = known && placed(0, 0, 0);
  if (!middle || !half().height) return;
  fitted = fitting();
  look(middle, fitted);
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

/** What the camera was last set to show. @type {Half} */
let shown = { width: 0, height: 0 };
let isWatching = false;

/** Nothing tells, either, that another board has come: one that is wider, or a square again. */
const watch = () => {
  if (isWatching) return;
  isWatching = true;
  setInterval(() => {
    const now = half();
    if (!known || !now.height) return;
    if (now.width === shown.width && now.height === shown.height) return;
    shown = now;
    resetView();
  }, 150);
};

/** What was asked for last, and whether it waits for the board. */
let asked = { width: 0, height: 0 };
let isWaiting = false;

/** Nothing in the page tells that the board has come. */
const aim = () => {
  isWaiting = false;
  const mutable = viewer();
  if (!mutable?.cameraControl || !half().height || !placed(0, 0, 0)) {
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
  watch();
  if (!isWaiting && width && height && !(isSame && viewer()?.cameraControl === known)) aim();
};

/** @param {(isDefault: boolean) => void} told whenever the view is all of the board, or is not */
export const whenViewChanges = (told) => (tell = told);
