#include "markup.h"
#include "sections.h"

namespace gluevo::apps {
namespace {

std::string Row(const std::string& name, const std::string& value) {
  return "<tr><th scope=\"row\">" + Escape(name) + "<td>" + Escape(value);
}

}  // namespace

std::string RecordSection(const RunReport& report) {
  std::string html = "<section><h2>Record</h2>\n<div class=\"columns\"><div>";
  html += "<div class=\"wide\"><table class=\"record\"><caption>Machine</caption><tbody>" +
          Row("processor", report.processor) + Row("instruction set", report.isa) +
          Row("threads", std::to_string(report.threads)) +
          Row("peak memory", Fixed(report.peak_memory_mb, 1) + " MB") +
          Row("run time", Fixed(report.duration_s, 2) + " s") + Row("gluevo", report.version) +
          "</tbody></table></div>";
  html += "<div class=\"wide\"><table class=\"record\"><caption>Weights</caption><tbody>";
  for (const WeightsLine& weights : report.weights) {
    html +=
        Row(weights.network, weights.name) + "<br><code>" + Escape(weights.checksum) + "</code>";
  }
  if (report.weights.empty()) {
    html += "<tr><td>none: the method needs no networks";
  }
  html +=
      "</tbody></table></div></div>\n<div class=\"wide\"><table class=\"record\"><caption>"
      "Options</caption><tbody>";
  for (const auto& [name, value] : report.options) {
    html += Row(name, value);
  }
  return html + "</tbody></table></div></div></section>\n";
}

}  // namespace gluevo::apps
