#include "gluevo/vo/frontend/match_store.h"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <iterator>
#include <utility>

#include "gluevo/nn/error.h"
#include "gluevo/vo/pipeline/odometry.h"
#include "message_of.h"
#include "temporary_folder.h"
#include "vo/scene.h"

namespace gluevo::vo {
namespace {

// Values that no shorter type holds.
TrackedFrame FrameAt(int64_t timestamp_ns, const std::vector<int64_t>& tracks) {
  TrackedFrame frame{timestamp_ns, {}, {}};
  for (const int64_t track : tracks) {
    Observation observation{.track_id = track};
    const double x = 1.0 / 3.0 + static_cast<double>(track + timestamp_ns);
    observation.left_pixel = {x, std::sqrt(x)};
    observation.left = observation.left_pixel / 7.0;
    observation.tracking_confidence = 0.1F;
    observation.has_right = track % 2 == 0;
    if (observation.has_right) {
      observation.right_pixel = {x - 0.1, std::sqrt(x)};
      observation.right = observation.right_pixel / 7.0;
      observation.stereo_confidence = 0.7F;
    }
    frame.observations.push_back(observation);
  }
  return frame;
}

void ExpectSame(const TrackedFrame& a, const TrackedFrame& b) {
  EXPECT_EQ(a.timestamp_ns, b.timestamp_ns);
  ASSERT_EQ(a.observations.size(), b.observations.size());
  for (std::size_t i = 0; i < a.observations.size(); ++i) {
    const Observation& x = a.observations[i];
    const Observation& y = b.observations[i];
    EXPECT_EQ(x.track_id, y.track_id);
    EXPECT_EQ(x.left_pixel, y.left_pixel);
    EXPECT_EQ(x.left, y.left);
    EXPECT_EQ(x.has_right, y.has_right);
    EXPECT_EQ(x.right_pixel, y.right_pixel);
    EXPECT_EQ(x.right, y.right);
    EXPECT_EQ(x.tracking_confidence, y.tracking_confidence);
    EXPECT_EQ(x.stereo_confidence, y.stereo_confidence);
  }
}

RunRecord SomeRecord() {
  return {"superglue", {{"max-keypoints", "300"}, {"empty", ""}}, {{"superpoint", "open"}}};
}

std::filesystem::path Store(const TemporaryFolder& folder, const StereoRig& rig,
                            const std::vector<TrackedFrame>& frames) {
  auto path = folder.path() / "matches.h5";
  MatchStoreWriter writer(path, rig, SomeRecord());
  for (const TrackedFrame& frame : frames) {
    writer.Add(frame);
  }
  EXPECT_FALSE(std::filesystem::exists(path));
  writer.Finish();
  return path;
}

StereoRig DistortedRig() {
  StereoRig rig = testing::SimulatedRig();
  rig.cameras[1].distortion = Distortion::kEquidistant;
  rig.cameras[1].coefficients = {1e-3, 1.0 / 3.0, 0, 0, 0};
  return rig;
}

TEST(MatchStoreTest, WhatIsWrittenIsReadBitForBit) {
  const TemporaryFolder folder;
  const std::vector<TrackedFrame> frames = {FrameAt(10, {4, 2, 7}), FrameAt(20, {}),
                                            FrameAt(35, {7, 9})};
  const MatchStoreReader reader(Store(folder, DistortedRig(), frames));
  EXPECT_EQ(reader.timestamps_ns(), (std::vector<int64_t>{10, 20, 35}));
  EXPECT_EQ(reader.record().method, "superglue");
  EXPECT_EQ(reader.record().options, SomeRecord().options);
  EXPECT_EQ(reader.record().weights, SomeRecord().weights);
  EXPECT_EQ(reader.rig().cameras[1].coefficients, DistortedRig().cameras[1].coefficients);
  EXPECT_EQ(reader.rig().cameras[1].distortion, Distortion::kEquidistant);
  for (std::size_t i = 0; i < frames.size(); ++i) {
    SCOPED_TRACE(i);
    ExpectSame(reader.Read(i), frames[i]);
  }
}

TEST(MatchStoreTest, TheSameRunGivesTheSameBytes) {
  const TemporaryFolder folder;
  const TemporaryFolder other;
  const auto bytes = [](const std::filesystem::path& path) {
    std::ifstream file(path, std::ios::binary);
    return std::string(std::istreambuf_iterator<char>(file), {});
  };
  const std::vector<TrackedFrame> frames = {FrameAt(10, {4, 2, 7}), FrameAt(20, {4})};
  EXPECT_EQ(bytes(Store(folder, DistortedRig(), frames)),
            bytes(Store(other, DistortedRig(), frames)));
}

TEST(MatchStoreTest, HundredFramesOf300KeypointsAreBelow20Megabytes) {
  const TemporaryFolder folder;
  std::vector<int64_t> tracks(300);
  std::vector<TrackedFrame> frames;
  for (int64_t i = 0; i < 100; ++i) {
    for (int64_t track = 0; track < 300; ++track) {
      tracks[static_cast<std::size_t>(track)] = track + 5 * i;
    }
    frames.push_back(FrameAt(i + 1, tracks));
  }
  EXPECT_LT(std::filesystem::file_size(Store(folder, DistortedRig(), frames)), 20U << 20U);
}

TEST(MatchStoreTest, AnUnfinishedStoreLeavesNothing) {
  const TemporaryFolder folder;
  {
    MatchStoreWriter writer(folder.path() / "matches.h5", DistortedRig(), SomeRecord());
    writer.Add(FrameAt(1, {1, 2}));
  }
  EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
}

TEST(MatchStoreTest, ReplayTakesAnyNumberOfItsFirstFrames) {
  const TemporaryFolder folder;
  const std::vector<TrackedFrame> frames = {FrameAt(10, {4}), FrameAt(20, {4, 5})};
  const auto path = Store(folder, DistortedRig(), frames);
  ReplayFrontEnd all(MatchStoreReader(path), DistortedRig(), {10, 20});
  ExpectSame(all.Track({10, {}}), frames[0]);
  ExpectSame(all.Track({20, {}}), frames[1]);
  EXPECT_THROW(all.Track({30, {}}), Error);
  ReplayFrontEnd first(MatchStoreReader(path), DistortedRig(), {10});
  EXPECT_THROW(first.Track({11, {}}), Error);
}

TEST(MatchStoreTest, ReplayRefusesOtherData) {
  const TemporaryFolder folder;
  const StereoRig rig = DistortedRig();
  const auto path = Store(folder, rig, {FrameAt(10, {4}), FrameAt(20, {4, 5})});
  const auto replay = [&](const StereoRig& other, const std::vector<int64_t>& times) {
    return MessageOf([&] { ReplayFrontEnd(MatchStoreReader(path), other, times); });
  };
  EXPECT_EQ(replay(rig, {10, 20}), "no error");
  EXPECT_NE(replay(rig, {10, 20, 30}).find("2 frames there, 3"), std::string::npos);
  EXPECT_NE(replay(rig, {10, 30}).find("frame 1 is at 20 ns there and at 30"), std::string::npos);
  StereoRig smaller = rig;
  smaller.cameras[0].width = 700;
  EXPECT_NE(replay(smaller, {10, 20}).find("752 x 480 pixels there"), std::string::npos);
  StereoRig turned = rig;
  turned.body_from_cam[1].translation.x() += 1e-12;
  EXPECT_NE(replay(turned, {10, 20}).find("camera 1 is calibrated differently"), std::string::npos);
  StereoRig bent = rig;
  bent.cameras[0].coefficients[2] = 1e-9;
  EXPECT_NE(replay(bent, {10, 20}).find("camera 0"), std::string::npos);
}

TEST(MatchStoreTest, OtherFilesAreNamed) {
  const TemporaryFolder folder;
  const auto absent = folder.path() / "absent.h5";
  EXPECT_NE(MessageOf([&] { MatchStoreReader reader(absent); }).find("absent.h5"),
            std::string::npos);
  const auto text = folder.path() / "text.h5";
  std::ofstream(text) << "no HDF5";
  EXPECT_NE(MessageOf([&] { MatchStoreReader reader(text); }).find("text.h5"), std::string::npos);
}

TEST(MatchStoreTest, TracksThatAreThereTwiceAreRefused) {
  const TemporaryFolder folder;
  const MatchStoreReader reader(Store(folder, DistortedRig(), {FrameAt(10, {4, 4})}));
  EXPECT_NE(MessageOf([&] { reader.Read(0); }).find("track 4 twice"), std::string::npos);
}

// What the estimator makes of a stored run is bit for bit what it made of the run itself, retries
// and resets included.
TEST(MatchStoreTest, TheEstimatorGivesTheSamePoses) {
  // Loses all its tracks at some frames; Retry has an answer at one of them.
  class LosingFrontEnd final : public FrontEnd {
   public:
    explicit LosingFrontEnd(const StereoRig& rig) : rig_(rig) {}
    TrackedFrame Track(const StereoFrame& frame) override {
      const int index = static_cast<int>(frame.timestamp_ns / 100'000'000);
      const Rigid3 pose{Eigen::Quaterniond::Identity(), {0.02 * index, 0.0, 0.01 * index}};
      real_ = testing::Simulate(rig_, points_, pose, frame.timestamp_ns, {});
      TrackedFrame given = real_;
      if (index == 5 || index == 9) {
        for (Observation& observation : given.observations) {
          observation.track_id += 1000 * index;
        }
      }
      can_retry_ = index == 5;
      return given;
    }
    std::optional<TrackedFrame> Retry() override {
      if (!std::exchange(can_retry_, false)) {
        return std::nullopt;
      }
      return real_;
    }

   private:
    StereoRig rig_;
    std::vector<Eigen::Vector3d> points_ = testing::RoomPoints(300, 4.0, 3);
    TrackedFrame real_;
    bool can_retry_ = false;
  };

  const TemporaryFolder folder;
  const auto path = folder.path() / "run.h5";
  const StereoRig rig = testing::SimulatedRig();
  std::vector<int64_t> times;
  for (int i = 1; i <= 14; ++i) {
    times.push_back(100'000'000 * i);
  }
  OdometryOptions options;
  options.max_predicted_s = 0.0;  // So that a lost frame ends a segment.
  std::vector<FrameResult> results;
  {
    Odometry odometry(rig, std::make_unique<LosingFrontEnd>(rig), options);
    MatchStoreWriter writer(path, rig, SomeRecord());
    for (const int64_t time : times) {
      results.push_back(odometry.Process({time, {}}));
      writer.Add(results.back().tracked_frame);
    }
    writer.Finish();
  }
  ASSERT_EQ(results[4].segment, 0);
  ASSERT_GT(results.back().segment, 0);
  Odometry replay(rig, std::make_unique<ReplayFrontEnd>(MatchStoreReader(path), rig, times),
                  options);
  for (std::size_t i = 0; i < times.size(); ++i) {
    SCOPED_TRACE(i);
    const FrameResult result = replay.Process({times[i], {}});
    EXPECT_EQ(result.world_from_body.translation, results[i].world_from_body.translation);
    EXPECT_EQ(result.world_from_body.rotation.coeffs(),
              results[i].world_from_body.rotation.coeffs());
    EXPECT_EQ(result.is_keyframe, results[i].is_keyframe);
    EXPECT_EQ(result.segment, results[i].segment);
  }
}

}  // namespace
}  // namespace gluevo::vo
