// gluevo doctor as a user runs it: the page, JSON, and exit codes.

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <string>

#include "apps/command_test.h"

namespace gluevo::apps {
namespace {

class DoctorTest : public CommandTest {};

TEST_F(DoctorTest, PrintsAPageOrJson) {
  ASSERT_EQ(
      Run("simulate -o " + Path("flight") + " --width 320 --height 240 --duration 1 --threads 2")
          .exit_code,
      0);
  const Outcome page = Run("doctor " + Path("flight") + " --pairs 3");
  EXPECT_EQ(page.exit_code, 0) << page.out << page.error;
  EXPECT_NE(page.out.find("epipolar error"), std::string::npos) << page.out;
  EXPECT_NE(page.out.find(" 0 wrong\n"), std::string::npos) << page.out;
  const Outcome json = Run("doctor " + Path("flight") + " --pairs 3 --json");
  EXPECT_EQ(nlohmann::json::parse(json.out)["wrong"], 0);
}

TEST_F(DoctorTest, ExitsOneWhereSomethingIsWrong) {
  const Outcome outcome = Run("doctor " + Path("nowhere") + " --json");
  EXPECT_EQ(outcome.exit_code, 1);
  const nlohmann::json json = nlohmann::json::parse(outcome.out);
  EXPECT_EQ(json["findings"][0]["verdict"], "wrong");
  EXPECT_NE(outcome.error.find("1 thing is wrong"), std::string::npos) << outcome.error;
  EXPECT_EQ(Run("doctor " + Path("nowhere") + " --pairs 0").exit_code, 2);
}

}  // namespace
}  // namespace gluevo::apps
