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

/** @typedef {{x: number, y: number, z: number, clone: () => Vector, distanceTo: (other: Vector) => number}} Vector */

/** The camera's controls that have been set up. @type {any} */
let known = null;
/** Whose corner was found last, and how far it lies from the middle. @type {[unknown, number]} */
let corner = [null, 0];
/** What would show all of the board in the room as it was last. */
let fitted = 0;
/** @type {(isDefault: boolean) => void} */
let tell = () => {};

/** viser's own, once it has a picture. @returns {any} */
const viewer = () => /** @type {any} */ (window).__viserMutable;

/** Half the side of the board: its outermost cell's far edge. @returns {number} */
const halfSide = () => {
  const points =
    /** @type {any} */ (window).__viserSceneTree?.getState()[CELLS]?.message.props.points;
  if (!points || points.length < 6) return 0;
  if (corner[0] !== points) corner = [points, Math.abs(points[0]) + (points[3] - points[0]) / 2];
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
  const half = halfSide() * (1 + 2 * MARGIN);
  return half / (Math.tan((camera.fov * Math.PI) / 360) * Math.min(1, camera.aspect));
};

const isDefault = () => {
  const middle = placed(0, 0, 0);
  if (!known || !middle || !fitted) return true;
  const off = known.getTarget(middle.clone()).distanceTo(middle) / halfSide();
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
  if (!middle || !halfSide()) return;
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

/** What was asked for last, and whether it waits for the board. */
let asked = { width: 0, height: 0 };
let isWaiting = false;

/** Nothing in the page tells that the board has come. */
const aim = () => {
  isWaiting = false;
  const mutable = viewer();
  if (!mutable?.cameraControl || !halfSide() || !placed(0, 0, 0)) {
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
