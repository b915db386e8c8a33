// SPDX-License-Identifier: Apache-2.0
// A canvas in the resolution of the screen.

export const COLOURS = ["#56b4e9", "#e69f00", "#009e73", "#cc79a7", "#f0e442"];
export const ROCK = "#a08060", SOFT = "#a9afb8";

export function paper(canvas) {
  const ratio = devicePixelRatio || 1, width = canvas.clientWidth, height = canvas.clientHeight;
  if (canvas.width !== Math.round(width * ratio) || canvas.height !== Math.round(height * ratio)) { canvas.width = Math.round(width * ratio); canvas.height = Math.round(height * ratio); }
  const pen = canvas.getContext("2d"); pen.setTransform(ratio, 0, 0, ratio, 0, 0); pen.clearRect(0, 0, width, height);
  return [pen, width, height];
}
