#include "gluevo/nn/isa.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "gluevo/nn/error.h"
#include "kernels/kernels.h"

namespace gluevo::nn {
namespace {

// Sets GLUEVO_ISA, or takes it away, and puts it back.
class IsaTest : public testing::Test {
 protected:
  IsaTest() {
    if (const char* const value = std::getenv(kName)) {
      before_ = value;
      was_set_ = true;
    }
    unsetenv(kName);
  }
  ~IsaTest() override { was_set_ ? setenv(kName, before_.c_str(), 1) : unsetenv(kName); }

  static void Set(const std::string& value) { setenv(kName, value.c_str(), 1); }

 private:
  static constexpr const char* kName = "GLUEVO_ISA";
  std::string before_;
  bool was_set_ = false;
};

// Every value of the enumeration, supported here or not.
std::vector<Isa> AllIsas() {
  std::vector<Isa> isas;
  for (int i = 0; IsaName(static_cast<Isa>(i)) != "unknown"; ++i) {
    isas.push_back(static_cast<Isa>(i));
  }
  return isas;
}

bool IsSupported(Isa isa) {
  const std::vector<Isa> supported = SupportedIsas();
  return std::find(supported.begin(), supported.end(), isa) != supported.end();
}

TEST_F(IsaTest, SupportedSetsGoFromSlowestToFastest) {
  const std::vector<Isa> supported = SupportedIsas();
  EXPECT_TRUE(std::is_sorted(supported.begin(), supported.end()));
  EXPECT_EQ(std::adjacent_find(supported.begin(), supported.end()), supported.end());
  EXPECT_TRUE(IsSupported(Isa::kReference));
  EXPECT_TRUE(IsSupported(Isa::kPortable));
}

#if defined(__x86_64__)
// What the system says of the processor is another source than the kernels' own detection.
TEST_F(IsaTest, SupportedSetsAreThoseOfTheProcessor) {
  std::ifstream file("/proc/cpuinfo");
  std::string line;
  while (std::getline(file, line) && line.rfind("flags", 0) != 0) {
  }
  std::istringstream words(line);
  std::set<std::string> flags;
  for (std::string word; words >> word;) {
    flags.insert(word);
  }
  ASSERT_TRUE(flags.count("sse2") == 1) << "no flags in /proc/cpuinfo";
  const auto has = [&](std::initializer_list<const char*> names) {
    return std::all_of(names.begin(), names.end(),
                       [&](const char* name) { return flags.count(name) == 1; });
  };
  EXPECT_EQ(IsSupported(Isa::kAvx2), has({"avx2", "fma"}));
  EXPECT_EQ(IsSupported(Isa::kAvx512),
            has({"avx512f", "avx512bw", "avx512cd", "avx512dq", "avx512vl"}));
}
#endif

TEST_F(IsaTest, TheFastestIsChosenUnlessTheEnvironmentNamesAnother) {
  EXPECT_EQ(ChooseIsa(), SupportedIsas().back());
  for (const Isa isa : SupportedIsas()) {
    Set(IsaName(isa));
    EXPECT_EQ(ChooseIsa(), isa);
  }
  Set("");
  EXPECT_EQ(ChooseIsa(), SupportedIsas().back());
}

TEST_F(IsaTest, WhatIsUnknownOrNotSupportedIsRefusedWithTheNamesOfWhatIs) {
  std::vector<std::string> refused = {"neon9", "AVX2", "avx2 ", "unknown"};
  for (const Isa isa : AllIsas()) {
    if (!IsSupported(isa)) {
      refused.push_back(IsaName(isa));
    }
  }
  std::string supported;
  for (const Isa isa : SupportedIsas()) {
    supported += (supported.empty() ? "" : ", ") + IsaName(isa);
  }
  for (const std::string& name : refused) {
    Set(name);
    try {
      ChooseIsa();
      FAIL() << name;
    } catch (const Error& error) {
      EXPECT_EQ(error.what(), "GLUEVO_ISA=" + name +
                                  " is not an instruction set that this CPU and this build "
                                  "support: " +
                                  supported);
    }
  }
}

TEST_F(IsaTest, SupportedSetsHaveKernelsAndOthersHaveNone) {
  for (const Isa isa : AllIsas()) {
    if (IsSupported(isa)) {
      const kernels::Kernels& kernels = kernels::KernelsFor(isa);
      EXPECT_EQ(kernels.isa, isa);
      EXPECT_NE(kernels.conv3x3, nullptr);
      EXPECT_NE(kernels.matmul, nullptr);
      EXPECT_NE(kernels.attention, nullptr);
      EXPECT_NE(kernels.detector_softmax, nullptr);
      EXPECT_NE(kernels.sinkhorn_rows, nullptr);
      EXPECT_NE(kernels.peak_flops, nullptr);
    } else {
      try {
        kernels::KernelsFor(isa);
        FAIL() << IsaName(isa);
      } catch (const Error& error) {
        EXPECT_NE(std::string(error.what()).find(IsaName(isa)), std::string::npos);
      }
    }
  }
}

}  // namespace
}  // namespace gluevo::nn
