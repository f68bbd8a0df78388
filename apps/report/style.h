#pragma once

#include <string_view>

namespace gluevo::apps {

/// The style sheet of a report. One accent colour; text has a contrast of at least 4.5 and lines of
/// at least 3 with what is behind them, in light and in dark; series differ in dashes, too.
inline constexpr std::string_view kStyle = R"css(
:root{--page:#fff;--card:#f5f6f8;--ink:#1b1f24;--muted:#59626d;--grid:#dfe3e8;--axis:#7b8490;
--accent:#0a5fc0;--truth:#a3abb5;--third:#7b8490;--warn:#a3360b;--warn-card:#fdf0ea;
--c0:#0d0887;--c1:#46039f;--c2:#7201a8;--c3:#9c179e;--c4:#bd3786;--c5:#d8576b;--c6:#e3683f;--c7:#d98200}
@media (prefers-color-scheme:dark){:root{--page:#14171b;--card:#1d2126;--ink:#e9ebee;--muted:#a6aeb8;
--grid:#2c323a;--axis:#87909b;--accent:#71b0ff;--truth:#6d7681;--third:#87909b;--warn:#ffab87;
--warn-card:#35211a;
--c0:#7a57e0;--c1:#9a4fd8;--c2:#b54ac4;--c3:#cc4fa6;--c4:#e0607f;--c5:#f07f57;--c6:#faa739;--c7:#f3e03a}}
*{box-sizing:border-box}
body{margin:0;background:var(--page);color:var(--ink);font:16px/1.5 system-ui,sans-serif}
main{max-width:1040px;margin:0 auto;padding:20px 16px 60px}
header p{margin:0}
.kind{color:var(--accent);font-weight:600}
h1{font-size:1.5rem;line-height:1.25;margin:0 0 2px;overflow-wrap:anywhere}
h2{font-size:1.2rem;margin:40px 0 6px;padding-top:14px;border-top:1px solid var(--grid)}
h3{font-size:1rem;margin:8px 0 4px}
p{margin:6px 0}
.tiles{display:grid;grid-template-columns:repeat(auto-fit,minmax(165px,1fr));gap:10px;margin:16px 0}
.tile{background:var(--card);border-radius:8px;padding:9px 12px}
.tile dt{color:var(--muted);font-size:.85rem}
.tile dd{margin:0;font-size:1.45rem;font-weight:600;line-height:1.3;font-variant-numeric:tabular-nums}
.tile small{font-size:.9rem;font-weight:400}
.tile span{display:block;color:var(--muted);font-size:.8rem;font-weight:400}
.tile.warn,.notice.warn{background:var(--warn-card)}
.tile.warn dd,.lost{color:var(--warn)}
.notice{background:var(--card);border-radius:8px;padding:9px 12px}
.notice.warn{border-left:4px solid var(--warn)}
.columns{display:grid;grid-template-columns:repeat(2,minmax(0,1fr));gap:14px 28px;align-items:start}
figure{margin:8px 0;min-width:0}
figcaption{display:flex;flex-wrap:wrap;gap:2px 14px;align-items:baseline;font-size:.9rem}
svg{display:block;width:100%;height:auto}
svg text{font-size:13px;fill:var(--muted)}
svg text.end{text-anchor:end}
svg text.middle{text-anchor:middle}
.legend{display:flex;flex-wrap:wrap;gap:2px 18px;font-size:.9rem}
.key{display:inline-flex;align-items:center;gap:6px;color:var(--muted)}
.swatch{width:24px;height:10px;flex:none}
.grid{stroke:var(--grid)}
.axis{stroke:var(--axis)}
polyline,.swatch line{fill:none;stroke-width:1.8;stroke-linejoin:round}
.first{stroke:var(--accent)}
.second{stroke:var(--ink);stroke-dasharray:5 3}
.third{stroke:var(--third);stroke-dasharray:1.5 2.5}
circle.first{fill:var(--accent)}circle.second{fill:var(--ink)}circle.third{fill:var(--third)}
line.mark{stroke:var(--warn);stroke-width:1.5}
.ticks{stroke:var(--ink);stroke-width:1;fill:none}
.truth{stroke:var(--truth);stroke-width:5!important;stroke-linecap:round}
.path{stroke-linecap:round}
.estimate{stroke:var(--accent)}
.loop{stroke:var(--warn);stroke-width:1.5}
.start{fill:var(--page);stroke:var(--ink);stroke-width:1.8}
.reset{fill:none;stroke:var(--warn);stroke-width:2}
.path.c0,.path.c1,.path.c2,.path.c3,.path.c4,.path.c5,.path.c6,.path.c7{stroke-width:3.5}
.c0{stroke:var(--c0)}.c1{stroke:var(--c1)}.c2{stroke:var(--c2)}.c3{stroke:var(--c3)}
.c4{stroke:var(--c4)}.c5{stroke:var(--c5)}.c6{stroke:var(--c6)}.c7{stroke:var(--c7)}
rect.c0{fill:var(--c0)}rect.c1{fill:var(--c1)}rect.c2{fill:var(--c2)}rect.c3{fill:var(--c3)}
rect.c4{fill:var(--c4)}rect.c5{fill:var(--c5)}rect.c6{fill:var(--c6)}rect.c7{fill:var(--c7)}
.scale{display:flex;flex-wrap:wrap;gap:4px 10px;align-items:center;font-size:.9rem;color:var(--muted)}
.scale svg{width:220px}
.scale rect{stroke:none}
.wide{overflow-x:auto}
table{border-collapse:collapse;width:100%;font-size:.9rem;font-variant-numeric:tabular-nums;margin:10px 0}
caption{text-align:left;color:var(--muted);padding-bottom:4px}
th,td{text-align:right;padding:4px 10px 4px 0;border-bottom:1px solid var(--grid);vertical-align:top}
th{font-weight:600}
th:first-child,td:first-child{text-align:left}
td.bar{width:40%;padding-right:0;vertical-align:middle}
td.bar svg{height:10px}
.p95{fill:var(--grid)}
.median{fill:var(--accent)}
.record td{text-align:left;overflow-wrap:anywhere}
.record th{text-align:left;white-space:nowrap;font-weight:400;color:var(--muted)}
code{font:.85em ui-monospace,monospace;overflow-wrap:anywhere}
.strip{display:grid;grid-template-columns:repeat(2,minmax(0,1fr));gap:10px 14px}
.strip figure{margin:0}
.strip figcaption{display:block;margin-top:3px;color:var(--muted)}
.strip b{color:var(--ink)}
.strip svg{border-radius:4px}
.halo{stroke:#000;stroke-opacity:.55;stroke-width:2.6;fill:none;stroke-linecap:round}
.motion{stroke:#ffd54a;stroke-width:1.2;fill:none;stroke-linecap:round}
.dot{fill:none;stroke-linecap:round}
.dot.end{stroke:#ffd54a;stroke-width:3}
.dot.new{stroke:#fff;stroke-opacity:.8;stroke-width:2.2}
@media (max-width:700px){.columns,.strip{grid-template-columns:minmax(0,1fr)}
main{padding:14px 12px 40px}.tiles{grid-template-columns:repeat(auto-fit,minmax(140px,1fr));gap:8px}}
)css";

}  // namespace gluevo::apps
