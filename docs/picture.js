// Run at the end of a report: leaves the path from above and the frame with the most tracks that go
// on, side by side, 1200 x 480 pixels. docs/make_picture.sh takes its picture.
const find = (selector, within = document) => {
  const found = within.querySelector(selector);
  if (!found) throw new Error(`the report has no ${selector}`);
  return found;
};
const counts = /Frame \d+, ([\d.]+) s.*Left: (\d+) tracked, (\d+) new/;
const figures = [...find('.strip').querySelectorAll('figure')]
  .map((figure) => ({ figure, said: counts.exec(figure.textContent) }))
  .filter(({ said }) => said)
  .sort((a, b) => b.said[2] - a.said[2]);
const { figure, said: [, seconds, tracked, fresh] } = figures[0];
const ate = [...document.querySelectorAll('dt')].find((dt) => dt.textContent.startsWith('ATE'));

// A photograph in all 256 levels would be a PNG twice as large.
const levels = Array.from({ length: 32 }, (_, i) => (i / 31).toFixed(4)).join(' ');
const filter = `<svg style="position:absolute" width="0" height="0"><filter id="levels"
  color-interpolation-filters="sRGB"><feComponentTransfer>
  ${['R', 'G', 'B'].map((c) => `<feFunc${c} type="discrete" tableValues="${levels}"/>`).join('')}
  </feComponentTransfer></filter></svg>`;
const style = `html{background:#fff}
  body{width:1200px;height:480px;max-width:none;margin:0;overflow:hidden;padding:16px 20px}
  h1{font-size:20px;margin:0 0 10px}
  .halves{display:grid;grid-template-columns:570px 570px;gap:20px}
  figure{margin:0}
  figcaption,.legend{font-size:15px;color:var(--ink);margin-bottom:6px;display:flex}
  figure image{filter:url(#levels)}`;
document.body.innerHTML = `<style>${style}</style>${filter}
  <h1>A rendered flight of 20 seconds, by SuperPoint and SuperGlue:
  ${parseFloat(ate.nextElementSibling.textContent)} m off (ATE)</h1>
  <div class="halves">
  <div class="path-picture">${find('.legend').outerHTML}
  ${find('svg[aria-label="From above"]').outerHTML}</div>
  <figure><figcaption>Left image at ${seconds} s: ${tracked} tracks that go on (yellow), ${fresh} new
  (white)</figcaption>${find('svg', figure).outerHTML}</figure></div>`;
document.title = 'ready';
