// SPDX-License-Identifier: Apache-2.0
// plotly.js, unpacked from the page itself; rejected where the browser cannot do that.
"use strict";

function bytes(text) {
  const plain = atob(text), result = new Uint8Array(plain.length);
  for (let i = 0; i < plain.length; i++) result[i] = plain.charCodeAt(i);
  return result;
}

const plotlyReady = (async function () {
  const packed = bytes(document.getElementById("plotly-packed").textContent.trim());
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("gzip"));
  const script = document.createElement("script");
  script.textContent = await new Response(stream).text();
  document.head.appendChild(script);
})();
