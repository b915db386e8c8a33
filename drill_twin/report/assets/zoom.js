// SPDX-License-Identifier: Apache-2.0
// Figures of the report: a click shows a figure at its full size, with the point that was clicked in the middle.
"use strict";

for (const picture of document.querySelectorAll(".picture")) {
  picture.addEventListener("click", (event) => {
    const edge = picture.getBoundingClientRect();
    const share = (picture.scrollLeft + event.clientX - edge.left) / picture.scrollWidth;
    picture.classList.toggle("full");
    picture.scrollLeft = share * picture.scrollWidth - edge.width / 2;
  });
}
