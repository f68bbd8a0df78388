#include "gluevo/vo/pipeline/live_pipeline.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <future>
#include <map>
#include <mutex>
#include <thread>
#include <vector>

#include "gluevo/nn/error.h"
#include "message_of.h"
#include "vo/inertial/inertial_flight.h"
#include "vo/scene.h"

namespace gluevo::vo {
namespace {

constexpr int64_t kFrameNs = 100'000'000;
constexpr double kAnyAge = 1e6;

// What the rig sees at the frame's time, whichever frames come.
class TimedFrontEnd final : public FrontEnd {
 public:
  explicit TimedFrontEnd(const std::vector<TrackedFrame>& frames) {
    for (const TrackedFrame& frame : frames) {
      frames_[frame.timestamp_ns] = frame;
    }
  }
  TrackedFrame Track(const StereoFrame& frame) override {
    const auto found = frames_.find(frame.timestamp_ns);
    if (found == frames_.end()) {
      throw Error("no such frame");
    }
    return found->second;
  }

 private:
  std::map<int64_t, TrackedFrame> frames_;
};

struct Flown {
  explicit Flown(int count) : flight(8, ImuNoise(), /*is_ideal=*/false, 3) {
    const auto points = testing::RoomPoints(3000, 6.0, 3);
    for (int i = 1; i <= count; ++i) {
      frames.push_back(testing::Simulate(testing::SimulatedRig(), points,
                                         flight.StateAt(i * kFrameNs).world_from_body, i * kFrameNs,
                                         {.noise_px = 0.5}));
    }
  }
  Odometry MakeOdometry(bool has_imu) const {
    Odometry odometry(testing::SimulatedRig(), std::make_unique<TimedFrontEnd>(frames),
                      OdometryOptions());
    if (has_imu) {
      odometry.UseImu(ImuNoise());
    }
    return odometry;
  }
  LivePipeline::Clock Now() const {
    return [end = frames.back().timestamp_ns] { return end + 30'000'000; };
  }

  InertialFlight flight;
  std::vector<TrackedFrame> frames;
};

TEST(LivePipelineTest, WithoutDropsItIsOdometryBitForBit) {
  const Flown flown(60);
  Odometry odometry = flown.MakeOdometry(true);
  odometry.AddImu(flown.flight.samples);
  std::vector<LiveResult> live;
  int tracked = 0;
  LiveStatistics statistics;
  {
    LivePipeline pipeline(
        flown.MakeOdometry(true),
        {.tracked = [&](const StereoFrame&, FrameResult&, const Odometry&) { ++tracked; },
         .result = [&](const LiveResult& result) { live.push_back(result); }},
        flown.Now(), {.queue_frames = 100, .max_age_s = kAnyAge, .imu_wait_s = 10.0});
    // The first reading is there before a frame could take the unit for silent.
    pipeline.Push(flown.flight.samples.front());
    const std::jthread readings([&] {
      for (std::size_t i = 1; i < flown.flight.samples.size(); ++i) {
        pipeline.Push(flown.flight.samples[i]);
      }
    });
    for (const TrackedFrame& frame : flown.frames) {
      pipeline.Push(StereoFrame{frame.timestamp_ns, {}});
    }
    statistics = pipeline.Finish();
    EXPECT_TRUE(pipeline.odometry().inertial()->begin());
  }
  ASSERT_EQ(live.size(), flown.frames.size());
  EXPECT_EQ(tracked, 60);
  for (const LiveResult& one : live) {
    const FrameResult result = odometry.Process({one.frame.timestamp_ns, {}});
    EXPECT_EQ(result.world_from_body.translation, one.result.world_from_body.translation);
    EXPECT_EQ(result.world_from_body.rotation.coeffs(),
              one.result.world_from_body.rotation.coeffs());
    EXPECT_EQ(result.inertial.has_value(), one.result.inertial.has_value());
  }
  EXPECT_EQ(statistics.frames_pushed, 60);
  EXPECT_EQ(statistics.frames_tracked, 60);
  EXPECT_EQ(statistics.frames_dropped, 0);
  EXPECT_EQ(statistics.readings_left_out, 0);
}

TEST(LivePipelineTest, WhileTrackingIsBusyTheOldestFramesAreDropped) {
  const Flown flown(6);
  std::promise<void> is_busy, may_go_on;
  std::vector<int64_t> tracked;
  LivePipeline pipeline(flown.MakeOdometry(false),
                        {.tracked =
                             [&](const StereoFrame& frame, FrameResult&, const Odometry&) {
                               tracked.push_back(frame.timestamp_ns / kFrameNs);
                               if (tracked.size() == 1) {
                                 is_busy.set_value();
                                 may_go_on.get_future().wait();
                               }
                             }},
                        flown.Now(), {.queue_frames = 2, .max_age_s = kAnyAge});
  pipeline.Push(StereoFrame{flown.frames[0].timestamp_ns, {}});
  is_busy.get_future().wait();
  for (int i = 1; i < 6; ++i) {
    pipeline.Push(StereoFrame{flown.frames[i].timestamp_ns, {}});
  }
  EXPECT_EQ(pipeline.statistics().frames_dropped, 3);
  may_go_on.set_value();
  const LiveStatistics statistics = pipeline.Finish();
  EXPECT_EQ(tracked, (std::vector<int64_t>{1, 5, 6}));
  EXPECT_EQ(statistics.frames_pushed, 6);
  EXPECT_EQ(statistics.frames_tracked, 3);
  EXPECT_EQ(statistics.frames_dropped, 3);
}

TEST(LivePipelineTest, OnAMachineThatIsTooSlowPosesAreRareButNotLate) {
  constexpr int64_t kTrackingNs = 140'000'000;
  const Flown flown(60);
  std::atomic<int64_t> now = 0;
  LivePipeline* live = nullptr;
  std::size_t pushed = 0;
  const auto push_what_has_come = [&] {
    while (pushed < flown.frames.size() && flown.frames[pushed].timestamp_ns <= now) {
      live->Push(StereoFrame{flown.frames[pushed++].timestamp_ns, {}});
    }
  };
  int64_t latest_ns = 0;
  LivePipeline pipeline(flown.MakeOdometry(false),
                        {.tracked =
                             [&](const StereoFrame& frame, FrameResult&, const Odometry&) {
                               now += kTrackingNs;
                               push_what_has_come();
                               // For the last one nothing newer comes.
                               if (pushed < flown.frames.size()) {
                                 latest_ns = std::max(latest_ns, now - frame.timestamp_ns);
                               }
                             }},
                        [&] { return now.load(); });
  live = &pipeline;
  now = kFrameNs;
  push_what_has_come();
  // Each frame that is tracked brings the next ones, up to the last.
  while (pipeline.statistics().frames_pushed < 60) {
    std::this_thread::yield();
  }
  const LiveStatistics statistics = pipeline.Finish();
  EXPECT_LE(latest_ns, static_cast<int64_t>(1e9 * LiveOptions().max_age_s) + kTrackingNs);
  EXPECT_LT(latest_ns, 300'000'000);
  EXPECT_EQ(statistics.frames_tracked + statistics.frames_dropped, 60);
  EXPECT_GE(statistics.frames_tracked, 60 * 100 / 140 - 1);
  EXPECT_GT(statistics.frames_dropped_old, 0);
}

TEST(LivePipelineTest, AFrameThatGrowsOldWhileItWaitsForReadingsGivesWay) {
  const Flown flown(3);
  std::atomic<int64_t> now = kFrameNs;
  std::promise<void> first;
  std::vector<int64_t> tracked;
  LivePipeline pipeline(flown.MakeOdometry(true),
                        {.tracked =
                             [&](const StereoFrame& frame, FrameResult&, const Odometry&) {
                               tracked.push_back(frame.timestamp_ns / kFrameNs);
                               if (tracked.size() == 1) {
                                 first.set_value();
                               }
                             }},
                        [&] { return now.load(); }, {.imu_wait_s = 10.0});
  std::size_t reading = 0;
  const auto push_readings_to = [&](int64_t time_ns) {
    while (reading < flown.flight.samples.size() &&
           flown.flight.samples[reading].timestamp_ns <= time_ns) {
      pipeline.Push(flown.flight.samples[reading++]);
    }
  };
  push_readings_to(kFrameNs);
  pipeline.Push(StereoFrame{1 * kFrameNs, {}});
  first.get_future().wait();
  pipeline.Push(StereoFrame{2 * kFrameNs, {}});
  now = 4 * kFrameNs;
  pipeline.Push(StereoFrame{3 * kFrameNs, {}});
  push_readings_to(3 * kFrameNs);
  const LiveStatistics statistics = pipeline.Finish();
  EXPECT_EQ(tracked, (std::vector<int64_t>{1, 3}));
  EXPECT_EQ(statistics.frames_dropped_old, 1);
}

TEST(LivePipelineTest, LatencyIsFromTheStampByTheCallersClock) {
  const Flown flown(10);
  std::vector<double> latencies;
  LivePipeline pipeline(
      flown.MakeOdometry(false),
      {.result = [&](const LiveResult& result) { latencies.push_back(result.latency_ms); }},
      flown.Now(), {.queue_frames = 20, .max_age_s = kAnyAge});
  for (const TrackedFrame& frame : flown.frames) {
    pipeline.Push(StereoFrame{frame.timestamp_ns, {}});
  }
  const LiveStatistics statistics = pipeline.Finish();
  ASSERT_EQ(latencies.size(), 10U);
  EXPECT_DOUBLE_EQ(latencies.back(), 30.0);
  EXPECT_DOUBLE_EQ(latencies.front(), 930.0);
  EXPECT_NEAR(statistics.latency_median_ms, 430.0, 5.0);
  EXPECT_NEAR(statistics.latency_p95_ms, 930.0, 10.0);
  EXPECT_DOUBLE_EQ(statistics.latency_max_ms, 930.0);
}

TEST(LivePipelineTest, WhatTheFrontEndRefusesIsLeftOutAndTold) {
  const Flown flown(4);
  std::vector<std::string> warnings;
  LivePipeline pipeline(
      flown.MakeOdometry(false),
      {.warning = [&](const std::string& warning) { warnings.push_back(warning); }}, flown.Now(),
      {.queue_frames = 20, .max_age_s = kAnyAge});
  pipeline.Push(StereoFrame{flown.frames[0].timestamp_ns, {}});
  pipeline.Push(StereoFrame{flown.frames[0].timestamp_ns + 5, {}});
  pipeline.Push(StereoFrame{flown.frames[1].timestamp_ns, {}});
  const LiveStatistics statistics = pipeline.Finish();
  EXPECT_EQ(statistics.frames_tracked, 2);
  EXPECT_EQ(statistics.frames_refused, 1);
  EXPECT_EQ(warnings, std::vector<std::string>{"frame left out: no such frame"});
}

TEST(LivePipelineTest, StampsThatDoNotIncreaseAreCounted) {
  const Flown flown(4);
  std::vector<std::string> warnings;
  LivePipeline pipeline(
      flown.MakeOdometry(false),
      {.warning = [&](const std::string& warning) { warnings.push_back(warning); }}, flown.Now(),
      {.queue_frames = 20, .max_age_s = kAnyAge});
  for (const int frame : {1, 1, 0, 2}) {
    pipeline.Push(StereoFrame{flown.frames[frame].timestamp_ns, {}});
  }
  const LiveStatistics statistics = pipeline.Finish();
  EXPECT_EQ(statistics.frames_tracked, 2);
  EXPECT_EQ(statistics.stamps_still, 1);
  EXPECT_EQ(statistics.stamps_back, 1);
  EXPECT_EQ(warnings.size(), 1U);
}

TEST(LivePipelineTest, AUnitThatFallsSilentDoesNotStopTheFrames) {
  const Flown flown(10);
  LivePipeline pipeline(flown.MakeOdometry(true), {}, flown.Now(),
                        {.queue_frames = 20, .max_age_s = kAnyAge, .imu_wait_s = 0.001});
  for (const int reading : {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 9, 12}) {  // One out of order.
    pipeline.Push(flown.flight.samples[reading]);
  }
  for (const TrackedFrame& frame : flown.frames) {
    pipeline.Push(StereoFrame{frame.timestamp_ns, {}});
  }
  const LiveStatistics statistics = pipeline.Finish();
  EXPECT_EQ(statistics.frames_tracked, 10);
  EXPECT_EQ(statistics.readings_left_out, 1);
}

TEST(LivePipelineTest, ACallbackThatThrowsEndsItAndIsHeardOf) {
  const Flown flown(20);
  for (const bool in_tracking : {true, false}) {
    LiveCallbacks callbacks;
    if (in_tracking) {
      callbacks.tracked = [](const StereoFrame&, FrameResult&, const Odometry&) {
        throw Error("the disk is full");
      };
    } else {
      callbacks.result = [](const LiveResult&) { throw Error("the disk is full"); };
    }
    LivePipeline pipeline(flown.MakeOdometry(false), callbacks, flown.Now());
    for (const TrackedFrame& frame : flown.frames) {
      pipeline.Push(StereoFrame{frame.timestamp_ns, {}});
    }
    EXPECT_EQ(MessageOf([&] { pipeline.Finish(); }), "the disk is full");
    pipeline.Push(StereoFrame{100 * kFrameNs, {}});  // Comes to nothing.
  }
}

TEST(LivePipelineTest, OptionsAreChecked) {
  const Flown flown(1);
  EXPECT_EQ(MessageOf([&] {
              const LivePipeline pipeline(flown.MakeOdometry(false), {}, flown.Now(),
                                          {.queue_frames = 0});
            }),
            "option live.queue_frames is 0; expected at least 1");
}

}  // namespace
}  // namespace gluevo::vo
