// GLUEVO_ISA as a user sets it.

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <string>

#include "apps/command_test.h"

namespace gluevo::apps {
namespace {

class IsaCommandTest : public CommandTest {
 protected:
  IsaCommandTest() {
    fs::create_directories(Path("images"));
    std::string pixels;
    for (int i = 0; i < 64 * 48; ++i) {
      pixels += static_cast<char>(i % 64 / 16 * 37 + i / 64 / 16 * 53);
    }
    Write("images/a.pgm", "P5 64 48 255\n" + pixels);
  }
  ~IsaCommandTest() override { unsetenv("GLUEVO_ISA"); }

  Outcome ExtractWith(const std::string& isa) const {
    setenv("GLUEVO_ISA", isa.c_str(), 1);
    return Run("extract " + Path("images") + " -o " + Path("features.h5"));
  }
};

TEST_F(IsaCommandTest, ASetThatIsNotThereIsRefusedInOneLine) {
  const Outcome outcome = ExtractWith("neon9");
  EXPECT_EQ(outcome.exit_code, 1);
  EXPECT_EQ(outcome.out, "");
  EXPECT_EQ(outcome.error.rfind("gluevo: error: GLUEVO_ISA=neon9 is not ", 0), 0U) << outcome.error;
  EXPECT_NE(outcome.error.find("portable"), std::string::npos) << outcome.error;
  EXPECT_EQ(std::count(outcome.error.begin(), outcome.error.end(), '\n'), 1);
  EXPECT_FALSE(fs::exists(Path("features.h5")));
}

TEST_F(IsaCommandTest, ASetThatIsThereIsUsed) {
  for (const char* const isa : {"reference", "portable", ""}) {
    const Outcome outcome = ExtractWith(isa);
    EXPECT_EQ(outcome.exit_code, 0) << isa << ": " << outcome.error;
    EXPECT_TRUE(fs::exists(Path("features.h5")));
  }
}

}  // namespace
}  // namespace gluevo::apps
