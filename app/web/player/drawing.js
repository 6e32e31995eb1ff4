// @ts-check
// What is shown is drawn anew when something of it is another, and no more often than there are frames.

/** Of one state, which several scripts draw. */
export const drawing = () => {
  /** @type {Array<() => void>} */
  const drawers = [];
  let isDue = false;
  return {
    /**
     * Draw with each frame in which something has changed.
     * @param {() => void} draw
     */
    whenChanged: (draw) => void drawers.push(draw),
    /** Something of the state is another: it is drawn with the next frame, however often it changes. */
    changed: () => {
      if (isDue) return;
      isDue = true;
      requestAnimationFrame(() => {
        isDue = false;
        for (const draw of drawers) draw();
      });
    },
  };
};
