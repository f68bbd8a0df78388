#include "gluevo/nn/isa.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <string>

#include "gluevo/nn/error.h"

namespace gluevo::nn {
namespace {

TEST(IsaTest, TheEnvironmentChoosesAndAnUnknownSetIsRefused) {
  for (const Isa isa : SupportedIsas()) {
    setenv("GLUEVO_ISA", IsaName(isa).c_str(), 1);
    EXPECT_EQ(ChooseIsa(), isa);
  }
  setenv("GLUEVO_ISA", "neon9", 1);
  try {
    ChooseIsa();
    FAIL();
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find("GLUEVO_ISA=neon9"), std::string::npos);
    EXPECT_NE(std::string(error.what()).find("portable"), std::string::npos);
  }
  unsetenv("GLUEVO_ISA");
  EXPECT_EQ(ChooseIsa(), SupportedIsas().back());
}

}  // namespace
}  // namespace gluevo::nn
