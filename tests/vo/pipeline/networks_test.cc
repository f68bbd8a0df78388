// Which files the networks' weights are found in, which pairs are refused, and that what is loaded
// runs.

#include "gluevo/vo/pipeline/networks.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <opencv2/core.hpp>

#include "gluevo/nn/random_weights.h"
#include "gluevo/vo/pipeline/frontend_config.h"
#include "gluevo/vo/pipeline/network_files.h"
#include "message_of.h"
#include "temporary_folder.h"
#include "vo/frontend/textured_views.h"

namespace gluevo::vo {
namespace {

namespace fs = std::filesystem;

nn::Weights SmallAliked() { return nn::RandomAlikedWeights({4, 6, 8, 10}, 64, 3); }
nn::Weights SmallLightGlue(int64_t descriptor_size = 64) {
  return nn::RandomLightGlueWeights(2, descriptor_size, 32, 2);
}

class NetworksTest : public ::testing::Test {
 protected:
  void SetUp() override { setenv("XDG_DATA_HOME", (folder_.path() / "home").c_str(), 1); }
  void TearDown() override { unsetenv("XDG_DATA_HOME"); }
  fs::path Own() const { return folder_.path() / "home" / "gluevo" / "weights"; }
  fs::path Weights() const { return folder_.path() / "weights"; }
  static fs::path Touch(const fs::path& file) {
    fs::create_directories(file.parent_path());
    nn::WriteSafetensors(file, SmallLightGlue());
    return file;
  }
  fs::path Save(const std::string& name, const nn::Weights& weights) const {
    nn::WriteSafetensors(folder_.path() / name, weights);
    return folder_.path() / name;
  }
  std::string Refusal(const NetworkFiles& files, const std::string& features,
                      const std::string& matcher) const {
    return MessageOf([&] { LoadNetworks(files, features, matcher); });
  }

 private:
  TemporaryFolder folder_;
};

TEST_F(NetworksTest, FilesAreFoundByTheirNames) {
  const NetworkFiles files = {.weights = Weights()};
  const fs::path superpoint = Touch(Weights() / "superpoint_v1.safetensors");
  const fs::path t16 = Touch(Weights() / "aliked-t16.safetensors");
  const fs::path lightglue = Touch(Weights() / "aliked_lightglue.safetensors");
  EXPECT_EQ(FindWeights(files, "superpoint", "superpoint"), superpoint);
  EXPECT_EQ(FindWeights(files, "superglue", "superpoint"), std::nullopt);
  // A LightGlue's name begins with that of its features.
  EXPECT_EQ(FindWeights(files, "aliked", "aliked"), t16);
  EXPECT_EQ(FindWeights(files, "lightglue", "aliked"), lightglue);

  Touch(Weights() / "aliked-n32.safetensors");
  Touch(Weights() / "lightglue-disk.safetensors");
  EXPECT_NE(MessageOf([&] { FindWeights(files, "aliked", "aliked"); })
                .find("several weights files of an aliked (aliked-n32.safetensors, "
                      "aliked-t16.safetensors, ...): name one with --aliked"),
            std::string::npos);
  EXPECT_NE(MessageOf([&] { FindWeights(files, "lightglue", "aliked"); }).find("--lightglue"),
            std::string::npos);
  const fs::path n16 = Touch(Weights() / "aliked-n16.safetensors");
  const fs::path for_aliked = Touch(Weights() / "lightglue-aliked.safetensors");
  EXPECT_EQ(FindWeights(files, "aliked", "aliked"), n16);
  EXPECT_EQ(FindWeights(files, "lightglue", "aliked"), for_aliked);
  const fs::path plain = Touch(Weights() / "aliked.safetensors");
  EXPECT_EQ(FindWeights(files, "aliked", "aliked"), plain);
  EXPECT_EQ(FindWeights({.weights = Weights(), .aliked = "named"}, "aliked", "aliked"), "named");
}

TEST_F(NetworksTest, TheUsersOwnFolderIsTheLastPlace) {
  EXPECT_EQ(MessageOf([] { FindWeights({}, "aliked", "aliked"); }),
            "--features aliked needs weights: run gluevo-weights get aliked-n16, or name a file "
            "with --aliked");
  EXPECT_EQ(MessageOf([] { FindWeights({}, "lightglue", "aliked"); }),
            "--matcher lightglue needs weights: run gluevo-weights get lightglue-aliked, or name a "
            "file with --lightglue");
  EXPECT_EQ(MessageOf([] { FindWeights({}, "lightglue", "superpoint"); }),
            "--matcher lightglue needs weights trained on SuperPoint's descriptors: name a file "
            "with --lightglue");
  EXPECT_EQ(FindWeights({}, "superpoint", "superpoint"), std::nullopt);
  const fs::path own = Touch(Own() / "aliked-n16.safetensors");
  EXPECT_EQ(FindWeights({}, "aliked", "aliked"), own);
  // A folder that is named comes before it, and its lack of this one network is made up for.
  Touch(Weights() / "superpoint.safetensors");
  EXPECT_EQ(FindWeights({.weights = Weights()}, "aliked", "aliked"), own);
  EXPECT_NE(
      MessageOf([&] { FindWeights({.weights = own}, "aliked", "aliked"); }).find("not a folder"),
      std::string::npos);
}

TEST_F(NetworksTest, AFolderThatIsNamedHoldsWhatIsRun) {
  fs::create_directories(Weights());
  fs::copy(Save("a", SmallAliked()), Weights() / "aliked.safetensors");
  EXPECT_EQ(Refusal({.weights = Weights()}, "superpoint", "superglue"),
            Weights().string() +
                ": no superpoint.safetensors and no superglue.safetensors in it (--weights)");
  EXPECT_EQ(Refusal({.weights = Weights()}, "aliked", "nn"), "no error");
  // The other one of a pair may be elsewhere.
  const fs::path lightglue = Save("l", SmallLightGlue());
  EXPECT_EQ(Refusal({.weights = Weights(), .lightglue = lightglue}, "aliked", "lightglue"),
            "no error");
  EXPECT_NE(MessageOf([&] {
              LoadMatcher({.weights = Weights()}, "", "lightglue");
            }).find("no lightglue.safetensors in it (--weights)"),
            std::string::npos);
}

TEST_F(NetworksTest, PairsThatDoNotFitAreRefusedByName) {
  const fs::path aliked = Save("a", SmallAliked());
  const fs::path lightglue = Save("l", SmallLightGlue());
  EXPECT_NE(Refusal({.aliked = aliked}, "aliked", "superglue").find("expected lightglue or nn"),
            std::string::npos);
  EXPECT_NE(Refusal({}, "sift", "nn").find("option features is \"sift\""), std::string::npos);
  EXPECT_NE(Refusal({}, "superpoint", "flann").find("option matcher is \"flann\""),
            std::string::npos);
  // Files of networks that are not run.
  EXPECT_NE(Refusal({.aliked = aliked}, "superpoint", "nn").find("expected --features aliked"),
            std::string::npos);
  EXPECT_NE(Refusal({.superpoint = aliked}, "aliked", "nn").find("expected --features superpoint"),
            std::string::npos);
  EXPECT_NE(Refusal({.superglue = lightglue, .aliked = aliked}, "aliked", "lightglue")
                .find("expected --matcher superglue"),
            std::string::npos);
  EXPECT_NE(
      Refusal({.lightglue = lightglue}, "superpoint", "superglue").find("--matcher lightglue"),
      std::string::npos);
  // Files of other networks than they should be.
  EXPECT_NE(Refusal({.aliked = lightglue}, "aliked", "nn").find(lightglue.string()),
            std::string::npos);
  EXPECT_NE(Refusal({.aliked = aliked, .lightglue = aliked}, "aliked", "lightglue")
                .find("these are an ALIKED's"),
            std::string::npos);
  // Descriptors of another size, and of other features.
  const fs::path wide = Save("w", SmallLightGlue(128));
  EXPECT_EQ(Refusal({.aliked = aliked, .lightglue = wide}, "aliked", "lightglue"),
            wide.string() + ": a LightGlue for descriptors of 128 values cannot match those of " +
                aliked.string() + ", which have 64 (--matcher nn matches any)");
  nn::Weights for_disk = SmallLightGlue();
  for_disk.metadata["features"] = "disk";
  const fs::path disk = Save("d", for_disk);
  EXPECT_NE(Refusal({.aliked = aliked, .lightglue = disk}, "aliked", "lightglue")
                .find("trained on \"disk\""),
            std::string::npos);
  for_disk.metadata["features"] = "aliked";
  EXPECT_EQ(Refusal({.aliked = aliked, .lightglue = Save("d", for_disk)}, "aliked", "lightglue"),
            "no error");
  // Whose features they are need not be known.
  for_disk.metadata["features"] = "disk";
  EXPECT_NE(LoadMatcher({.lightglue = Save("d", for_disk)}, "", "lightglue").lightglue, nullptr);
}

TEST_F(NetworksTest, AlikedAndLightGlueFindDescribeAndMatch) {
  const fs::path aliked = Save("a", SmallAliked());
  const fs::path lightglue = Save("l", SmallLightGlue());
  const Networks networks =
      LoadNetworks({.aliked = aliked, .lightglue = lightglue}, "aliked", "lightglue");
  ASSERT_EQ(networks.records.size(), 2U);
  EXPECT_EQ(networks.records[0].network, "aliked");
  EXPECT_EQ(networks.records[0].source, aliked.string());
  EXPECT_EQ(networks.records[1].network, "lightglue");
  EXPECT_EQ(networks.records[1].checksum, nn::ReadWeights(lightglue).checksum);
  EXPECT_EQ(networks.superpoint, nullptr);
  EXPECT_EQ(networks.superglue, nullptr);

  nn::ThreadPool pool(2);
  const auto extractor =
      MakeExtractor(networks, {.keypoint_threshold = 0.0F, .max_keypoints = 30}, pool);
  EXPECT_EQ(extractor->Name(), "aliked");
  const cv::Mat image = testing::PatternAt(0, 0, 96, 64);
  const nn::Features features = extractor->Extract(image);
  ASSERT_GT(features.size(), 10);
  EXPECT_LE(features.size(), 30);
  EXPECT_EQ(features.descriptors.cols(), 64);
  const nn::Features described = extractor->Describe(image, features.keypoints);
  EXPECT_EQ(described.descriptors, features.descriptors);
  EXPECT_THROW(extractor->Extract(cv::Mat(64, 96, CV_16UC1)), Error);

  const auto matcher = MakeMatcher(networks, pool);
  const nn::Matches matches = matcher->Match(features, features, 0.0F);
  EXPECT_EQ(matches.matches0.size(), static_cast<std::size_t>(features.size()));
  EXPECT_THROW(MakeMatcher(networks, pool, {.depth_confidence = 1.0F}), Error);
  EXPECT_THROW(MakeExtractor(networks, {.max_keypoints = 0}, pool), Error);
}

// Weights without token_confidence, as XFeat's LighterGlue has them.
TEST_F(NetworksTest, ALightGlueThatCannotTellWhenToStopRunsToItsEnd) {
  nn::Weights weights = SmallLightGlue();
  weights.tensors.erase("token_confidence.0.token.0.weight");
  weights.tensors.erase("token_confidence.0.token.0.bias");
  const Networks networks = LoadMatcher({.lightglue = Save("l", weights)}, "aliked", "lightglue");
  nn::ThreadPool pool(1);
  nn::Features features;
  features.width = features.height = 50;
  features.keypoints.setRandom(8, 2);
  features.descriptors.setRandom(8, 64);
  EXPECT_NO_THROW(MakeMatcher(networks, pool)->Match(features, features, 0.1F));
}

TEST_F(NetworksTest, BothMethodsTakeAliked) {
  const fs::path aliked = Save("a", SmallAliked());
  for (const std::string method : {"superglue", "superpoint"}) {
    FrontEndConfig config = {.method = method, .features = "aliked", .matcher = "nn"};
    config.networks.aliked = aliked;
    config.keypoints = {.keypoint_threshold = 0.0F, .max_keypoints = 50};
    nn::ThreadPool pool(1);
    StereoRig rig;
    for (Camera& camera : rig.cameras) {
      camera = {.width = 96, .height = 64, .fx = 50.0, .fy = 50.0, .cx = 48.0, .cy = 32.0};
    }
    rig.body_from_cam[1].translation = {0.1, 0.0, 0.0};
    const auto frontend = MakeFrontEnd(config, rig, LoadFrontEndNetworks(config), pool);
    const TrackedFrame frame =
        frontend->Track({1, {testing::PatternAt(0, 0, 96, 64), testing::PatternAt(-3, 0, 96, 64)}});
    EXPECT_FALSE(frame.observations.empty()) << method;
    EXPECT_TRUE(frame.stages_ms.contains("aliked")) << method;
  }
}

}  // namespace
}  // namespace gluevo::vo
