// The report and the map of gluevo run, from a small simulated flight; a real browser opens the
// report.

#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>
#include <string>

#include "apps/command_test.h"
#include "apps/report/html_check.h"

namespace gluevo::apps {
namespace {

class ReportTest : public CommandTest {
 protected:
  // A second of a flight, small.
  std::string Simulate() const {
    const std::string path = Path("flight");
    const Outcome outcome =
        Run("simulate -o " + path + " --duration 1.2 --width 376 --height 240 --path figure_eight");
    EXPECT_EQ(outcome.exit_code, 0) << outcome.error;
    return path;
  }

  struct Browsed {
    int exit_code = -1;
    std::string dom;
    std::string complaints;  // what the browser's console says of the page
  };
  Browsed Browse(const std::string& page) const {
    const std::string command =
        "chromium --headless --no-sandbox --disable-gpu --disable-dev-shm-usage --no-first-run "
        "--disable-background-networking --disable-component-update --user-data-dir=" +
        Path("profile") + " --enable-logging=stderr --dump-dom file://" + page + " >" +
        Path("dom") + " 2>" + Path("log");
    const int status = std::system(command.c_str());
    Browsed browsed{WIFEXITED(status) ? WEXITSTATUS(status) : -1, Contents(Path("dom")), ""};
    std::ifstream log(Path("log"));
    for (std::string line; std::getline(log, line);) {
      if (line.find("CONSOLE") != std::string::npos) {
        browsed.complaints += line + "\n";
      }
    }
    return browsed;
  }
};

TEST_F(ReportTest, IsOneFileThatShowsTheRun) {
  const std::string flight = Simulate();
  const Outcome outcome =
      Run("run " + flight + " --method klt -o " + Path("out") + " --map " + Path("map"));
  ASSERT_EQ(outcome.exit_code, 0) << outcome.error;
  const std::string html = Contents(Path("out/report.html"));
  ExpectSelfContained(html);
  for (const std::string part :
       {"ATE, SE(3)", "From above", "From the side", "Position error", "Matches a frame",
        "Milliseconds a frame", "Lines in the left image", "klt"}) {
    EXPECT_NE(html.find(part), std::string::npos) << part;
  }
  EXPECT_NE(html.find(flight), std::string::npos);
  EXPECT_NE(html.find("data:image/jpeg;base64,"), std::string::npos) << "the strip of frames";
  EXPECT_LT(html.size(), 3'000'000U);

  for (const std::string name : {"points.ply", "keyframes.ply", "colmap/0/cameras.txt",
                                 "colmap/0/images.txt", "colmap/0/points3D.txt"}) {
    EXPECT_TRUE(fs::exists(Path("map/" + name))) << name;
  }
  // Names under which COLMAP finds the images below the data set's folder.
  std::ifstream images(Path("map/colmap/0/images.txt"));
  int keyframes = 0;
  for (std::string line; std::getline(images, line);) {
    if (const std::size_t at = line.rfind(' '); line.ends_with(".png")) {
      EXPECT_TRUE(fs::exists(fs::path(flight) / line.substr(at + 1))) << line;
      ++keyframes;
    }
  }
  EXPECT_GE(keyframes, 2);
}

TEST_F(ReportTest, OpensInABrowserWithoutComplaint) {
  if (std::system("command -v chromium >/dev/null") != 0) {
    GTEST_SKIP() << "chromium is not installed (Debian package chromium)";
  }
  const std::string flight = Simulate();
  const Outcome outcome = Run("run " + flight + " --method klt -o " + Path("out"));
  ASSERT_EQ(outcome.exit_code, 0) << outcome.error;
  const Browsed browsed = Browse(Path("out/report.html"));
  ASSERT_EQ(browsed.exit_code, 0) << Contents(Path("log"));
  EXPECT_EQ(browsed.complaints, "");
  // What the browser made of it still has every part: nothing was malformed enough to be dropped.
  for (const std::string part : {"</header>", "From above", "</svg>", "</table>", "Options"}) {
    EXPECT_NE(browsed.dom.find(part), std::string::npos) << part;
  }

  // That the check can fail: a picture from elsewhere is refused, and heard of.
  std::string spoilt = Contents(Path("out/report.html"));
  spoilt.insert(spoilt.find("<main>"), "<img src=\"http://127.0.0.1:9/x.png\" alt=\"\">");
  const Browsed refused = Browse(Write("spoilt.html", spoilt));
  EXPECT_NE(refused.complaints.find("Content Security Policy"), std::string::npos);
}

TEST_F(ReportTest, WithoutGroundTruthSaysSo) {
  const std::string flight = Simulate();
  fs::remove_all(fs::path(flight) / "mav0" / "state_groundtruth_estimate0");
  const Outcome outcome = Run("run " + flight + " --method klt -o " + Path("out"));
  ASSERT_EQ(outcome.exit_code, 0) << outcome.error;
  EXPECT_NE(Contents(Path("out/report.html")).find("No ground truth"), std::string::npos);
}

}  // namespace
}  // namespace gluevo::apps
