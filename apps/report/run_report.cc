#include "run_report.h"

#include <ostream>

#include "gluevo/nn/output_file.h"
#include "markup.h"
#include "sections.h"
#include "style.h"

namespace gluevo::apps {

void WriteRunReport(const std::filesystem::path& path, const RunReport& report) {
  nn::WriteWholeFile(path, [&](std::ostream& out) {
    // The policy makes the browser refuse what the page must never ask for.
    out << "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
           "<meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; "
           "img-src data:; style-src 'unsafe-inline'\">\n"
           "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n"
           "<meta name=\"color-scheme\" content=\"light dark\">\n"
           "<link rel=\"icon\" href=\"data:,\">\n<title>"
        << Escape(report.dataset) << " \u00B7 gluevo run</title>\n<style>\n"
        << kStyle << "</style>\n</head>\n<body>\n<main>\n";
    for (const auto& section :
         {VerdictSection, TrajectorySection, ErrorSection, LoopsSection, MatchesSection,
          InertialSection, TimesSection, StripSection, RecordSection}) {
      out << section(report);
    }
    out << "</main>\n</body>\n</html>\n";
  });
}

}  // namespace gluevo::apps
