// Results that cannot be printed, and names that are not UTF-8.

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "apps/command_test.h"

namespace gluevo::apps {
namespace {

class StandardStreamsTest : public CommandTest {
 protected:
  // The exit code of the program itself, whatever its standard output is connected to.
  std::string Printed(const std::string& arguments, const std::string& to) const {
    const std::string command = "( " + std::string(GLUEVO_PROGRAM) + " " + arguments + " 2>" +
                                Path("error") + "; echo $? >" + Path("code") + " ) " + to;
    std::system(command.c_str());
    return Contents(Path("code"));
  }
};

TEST_F(StandardStreamsTest, OutputThatFailsIsAnError) {
  const std::string truth = Write("truth.tum",
                                  "1 0 0 0 0 0 0 1\n2 1 0 0 0 0 0 1\n3 1 1 0 0 0 0 1\n"
                                  "4 1 1 1 0 0 0 1\n");
  const std::string simulate = "simulate --duration 0.2 --width 64 --height 64 -o " + Path("made");
  const std::string evaluate = "evaluate " + truth + " " + truth;
  for (const std::string& command :
       {evaluate, evaluate + " --json", std::string("--help"), std::string("run --help"),
        std::string("--version"), simulate}) {
    for (const std::string to : {">/dev/full", ">&-", "| true"}) {
      SCOPED_TRACE(command + " " + to);
      fs::remove_all(Path("made"));
      const std::string code = Printed(to == "| true" ? command : command, to);
      // A pipe may be closed before or after what little there is went into it.
      EXPECT_TRUE(code == "1\n" || (to == "| true" && code == "0\n")) << code;
      if (code == "1\n") {
        EXPECT_NE(Contents(Path("error")).find("gluevo: error: standard output: cannot be written"),
                  std::string::npos)
            << Contents(Path("error"));
        if (to == ">/dev/full") {
          EXPECT_NE(Contents(Path("error")).find(": No space left on device"), std::string::npos)
              << Contents(Path("error"));
        }
      }
    }
  }
  EXPECT_EQ(Printed(evaluate, ">" + Path("table")), "0\n");
  EXPECT_NE(Contents(Path("table")).find("ATE"), std::string::npos);
}

TEST_F(StandardStreamsTest, NamesMayBeOfAnyBytes) {
  // Latin-1, quoted for the shell.
  const std::string data = Path(
      "donn\xe9"
      "es");
  ASSERT_EQ(
      Run("simulate --duration 0.5 --rate 10 --width 320 --height 240 -o '" + data + "'").exit_code,
      0);
  const std::string out = Path("r\xe9sultats");
  const Outcome outcome = Run("run '" + data + "' --method klt -o '" + out + "' --map '" + out +
                              "/c\xe0rte' --save-matches '" + out + ".h5'");
  EXPECT_EQ(outcome.exit_code, 0) << outcome.error;
  const auto metrics = nlohmann::json::parse(Contents(out + "/metrics.json"));
  EXPECT_NE(metrics["options"]["output"].get<std::string>().find("r\xEF\xBF\xBDsultats"),
            std::string::npos);
  EXPECT_NE(Contents(out + "/report.html")
                .find("donn\xEF\xBF\xBD"
                      "es"),
            std::string::npos);
  EXPECT_EQ(Run("run '" + data + "' --replay '" + out + ".h5' -o '" + out + "'").exit_code, 0);
  EXPECT_EQ(Run("evaluate '" + out + "/trajectory.tum' '" + data +
                "/mav0/state_groundtruth_estimate0/data.csv' --plot '" + out + "/plot.svg'")
                .exit_code,
            0);
  EXPECT_EQ(Run("extract '" + data + "' --max-keypoints 50 -o '" + out + "/f.h5'").exit_code, 0);
  const std::string list = Write("list.yaml", "data: [{path: .}]\nmethods: [klt]\n");
  const std::string experiment = "experiment " + list + " --data '" + data + "' -o '" + out + "'";
  EXPECT_EQ(Run(experiment).exit_code, 0);
  // What is done is known again.
  EXPECT_NE(Run(experiment).error.find("its result is there"), std::string::npos);
}

}  // namespace
}  // namespace gluevo::apps
