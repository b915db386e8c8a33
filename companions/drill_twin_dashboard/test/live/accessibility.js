// SPDX-License-Identifier: Apache-2.0
// Texts with too little contrast (WCAG 2.2, 1.4.3), and controls without a name (4.1.2).
(() => {
  const linear = (part) => part <= 0.04045 ? part / 12.92 : ((part + 0.055) / 1.055) ** 2.4;
  const light = (colour) => colour.match(/[\d.]+/g).slice(0, 3).map((part) => linear(part / 255))
    .reduce((sum, part, k) => sum + part * [0.2126, 0.7152, 0.0722][k], 0);
  const ground = (element) => {
    const colour = getComputedStyle(element).backgroundColor;
    return colour.startsWith("rgba(0, 0, 0, 0") && element.parentElement ? ground(element.parentElement) : colour;
  };
  const written = (element) => [...element.childNodes].some((node) => node.nodeType === 3 && node.textContent.trim());
  const shown = (name) => [...document.querySelectorAll(name)].filter((one) => one.checkVisibility() && !one.closest("svg"));
  const faint = shown("body *").filter((one) => written(one) && !one.disabled).filter((one) => {
    const [a, b] = [light(getComputedStyle(one).color), light(ground(one))];
    return (Math.max(a, b) + 0.05) / (Math.min(a, b) + 0.05) < 4.5;
  });
  const nameless = shown("button, input, select, summary, [tabindex]")
    .filter((one) => !(one.getAttribute("aria-label") || one.labels?.length || one.textContent.trim()));
  return [...faint, ...nameless].map((one) => one.outerHTML.slice(0, 200));
})()
