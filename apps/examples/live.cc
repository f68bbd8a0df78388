// Odometry as it happens: frames and readings are pushed as they come, poses are called back, those
// of frames that tracking has no time for are dropped. Here the frames are a data set's, at its own
// pace.
//   live DATASET [METHOD]

#include <chrono>
#include <cstdio>
#include <thread>

#include "gluevo/nn/error.h"
#include "gluevo/vo/pipeline/live_pipeline.h"
#include "gluevo/vo/pipeline/presets.h"

int main(int argc, char** argv) try {
  if (argc < 2) {
    std::fprintf(stderr, "usage: %s DATASET [METHOD]\n", argv[0]);
    return 2;
  }
  using SteadyClock = std::chrono::steady_clock;
  const gluevo::vo::Dataset dataset = gluevo::vo::OpenDataset(argv[1], {});
  const auto begin = SteadyClock::now();
  const int64_t first_ns = dataset.entries.front().timestamp_ns;
  // A camera's own stamps are read from the clock that makes them.
  const auto now_ns = [&] { return first_ns + (SteadyClock::now() - begin).count(); };

  gluevo::vo::OdometryConfig config = gluevo::vo::PresetConfig(gluevo::vo::PresetOf(dataset.format),
                                                               argc > 2 ? argv[2] : "superglue");
  // Networks run beside tracking: what they make of a frame comes in as soon as it is there.
  config.frontend.learned.network_lag = 1;
  config.frontend.learned.awaits_networks = false;
  gluevo::vo::LivePipeline pipeline(
      gluevo::vo::Odometry(dataset.rig, config),
      {.result =
           [](const gluevo::vo::LiveResult& live) {
             const Eigen::Vector3d& p = live.result.world_from_body.translation;
             std::printf("%.3f s: at %.3f %.3f %.3f m, %.0f ms after the image\n",
                         1e-9 * static_cast<double>(live.frame.timestamp_ns), p.x(), p.y(), p.z(),
                         live.latency_ms);
           }},
      now_ns);
  for (std::size_t i = 0; i < dataset.entries.size(); ++i) {
    gluevo::vo::StereoFrame frame = dataset.Read(i);
    std::this_thread::sleep_until(begin + std::chrono::nanoseconds(frame.timestamp_ns - first_ns));
    pipeline.Push(std::move(frame));
  }
  const gluevo::vo::LiveStatistics statistics = pipeline.Finish();
  std::printf("%lld frames, %lld dropped; 95 of 100 poses within %.0f ms\n",
              static_cast<long long>(statistics.frames_pushed),
              static_cast<long long>(statistics.frames_dropped), statistics.latency_p95_ms);
  return 0;
} catch (const gluevo::Error& error) {
  std::fprintf(stderr, "error: %s\n", error.what());
  return 1;
}
