#include "gluevo/vo/simulation/simulation.h"

#include <algorithm>
#include <cmath>
#include <mutex>
#include <opencv2/imgcodecs.hpp>
#include <set>

#include "asl.h"
#include "correspondences.h"
#include "flight.h"
#include "gluevo/nn/error.h"
#include "gluevo/nn/option_error.h"
#include "gluevo/nn/output_file.h"
#include "imu.h"
#include "movers.h"
#include "parallel_for.h"
#include "partial_directory.h"
#include "random.h"
#include "renderer.h"
#include "room.h"
#include "sensor.h"

namespace gluevo::simulation {
namespace {

/// Nanoseconds after the first image.
int64_t TimeNs(int64_t index, double rate_hz) {
  return std::llround(static_cast<double>(index) * 1e9 / rate_hz);
}

double Seconds(int64_t time_ns) { return static_cast<double>(time_ns) * 1e-9; }

/// The streams of randomness that a seed feeds.
enum Stream : uint64_t {
  kWorldStream = 1,
  kImuStream = 2,
  kImageStream = 3,
  kExposureStream = 4,
  kMoverStream = 5
};

void WriteImage(const std::filesystem::path& file, const cv::Mat& image) {
  std::vector<unsigned char> bytes;
  // Noise hardly compresses: level 1 gives the size of the default at a third of its time.
  if (!cv::imencode(file.extension().string(), image, bytes, {cv::IMWRITE_PNG_COMPRESSION, 1})) {
    throw Error(file.string() + ": cannot be encoded");
  }
  nn::WriteFileInPlace(file, [&](std::ostream& out) {
    out.write(reinterpret_cast<const char*>(bytes.data()),
              static_cast<std::streamsize>(bytes.size()));
  });
}

/// The body's poses during an exposure of `blur_ms` around `time_s`: one where it is at rest or the
/// exposure is short, else as many as keep the image's steps below a pixel (to at most 64).
std::vector<vo::Rigid3> PosesOfExposure(const SimulationPath& path, double time_s, double blur_ms,
                                        const vo::StereoRig& rig) {
  constexpr double kNearM = 1.5;  // What is nearer than this may show its steps.
  constexpr int kSamples = 4;     // Of a pixel, which share the poses.
  const double exposure_s = 1e-3 * blur_ms;
  const vo::Rigid3 body_from_end =
      path(time_s - 0.5 * exposure_s).Inverse() * path(time_s + 0.5 * exposure_s);
  const double turn = Eigen::AngleAxisd(body_from_end.rotation).angle();
  const double pixels =
      rig.cameras[0].fx * (std::abs(turn) + body_from_end.translation.norm() / kNearM);
  if (pixels < 0.1) return {path(time_s)};
  const int count = kSamples * std::clamp(static_cast<int>(std::ceil(pixels / kSamples)), 2, 16);
  std::vector<vo::Rigid3> poses;
  poses.reserve(static_cast<std::size_t>(count));
  for (int i = 0; i < count; ++i) {
    poses.push_back(path(time_s + exposure_s * ((i + 0.5) / count - 0.5)));
  }
  return poses;
}

std::vector<vo::Rigid3> Poses(const Flight& flight, const std::vector<int64_t>& times) {
  std::vector<vo::Rigid3> poses;
  poses.reserve(times.size());
  for (const int64_t time : times) poses.push_back(flight.path(Seconds(time)));
  return poses;
}

std::vector<int64_t> OnClock(std::vector<int64_t> times, int64_t start_ns) {
  for (int64_t& time : times) time += start_ns;
  return times;
}

/// `image_times` count from the first image.
void WriteStates(const std::filesystem::path& mav, const Flight& flight,
                 const std::vector<int64_t>& image_times, uint64_t seed) {
  const int imu_count =
      static_cast<int>(std::ceil(Seconds(image_times.back()) * kImuRateHz - 1e-6)) + 1;
  const vo::ImuNoise noise;
  const std::vector<ImuSample> samples = SimulateImu(flight.path, imu_count, noise, seed);
  std::vector<int64_t> imu_times(samples.size());
  for (int i = 0; i < imu_count; ++i) imu_times[i] = TimeNs(i, kImuRateHz);
  WriteAslImu(mav / "imu0" / "sensor.yaml", noise);
  WriteAslImuSamples(mav / "imu0" / "data.csv", OnClock(imu_times, flight.start_ns), samples);

  std::set<int64_t> times(imu_times.begin(), imu_times.end());
  times.insert(image_times.begin(), image_times.end());
  std::vector<AslState> states;
  for (const int64_t time : times) {
    const auto next = std::upper_bound(imu_times.begin(), imu_times.end(), time);
    const ImuSample& sample = samples[std::max<std::ptrdiff_t>(0, next - imu_times.begin() - 1)];
    states.push_back({flight.start_ns + time, MotionAt(flight.path, Seconds(time)),
                      sample.gyroscope_bias, sample.accelerometer_bias});
  }
  WriteAslGroundtruth(mav / "state_groundtruth_estimate0" / "data.csv", states);
}

}  // namespace

void ImageOptions::Validate() const {
  const auto check = [](double value, double low, double high, const std::string& what) {
    if (!(value >= low && value <= high)) throw OptionError("simulated images: " + what);
  };
  check(noise, 0.0, 100.0, "the noise must be 0 to 100 gray levels (--noise)");
  check(exposure_change, 0.0, 4.0,
        "the change of exposure must be 0 to 4 stops (--exposure-change)");
  check(vignetting, 0.0, 1.0,
        "the light lost by vignetting must be a share of 0 to 1 (--vignetting)");
  check(motion_blur_ms, 0.0, 100.0,
        "the exposure time of motion blur must be 0 to 100 ms (--motion-blur)");
  check(light, 0.001, 1.0, "the light must be 0.001 to 1 (--light)");
}

void SimulationOptions::Validate() const {
  if (trajectory.empty()) MakeSimulationPath(path);
  const auto check = [](bool good, const std::string& what) {
    if (!good) throw OptionError(what);
  };
  check(start_s >= 0.0 && start_s <= 7200.0,
        "the start of a simulation must be 0 to 7200 s (--start)");
  check(!from_takeoff || !trajectory.empty(),
        "only a trajectory has a take-off to start from, expected one in place of a named path");
  check(!duration_s || (*duration_s > 0.0 && *duration_s <= 3600.0),
        "the duration of a simulation must be above 0 and at most 3600 s (--duration)");
  check(laps >= 0 && laps <= 100, "the laps of a simulation must be 0 to 100 (--laps)");
  check(
      laps == 0 || (trajectory.empty() && !duration_s && start_s == 0.0),
      "laps (--laps) are those of a named path from its start, expected no trajectory, duration or "
      "start");
  check(rate_hz > 0.0 && rate_hz <= 200.0,
        "the rate of a simulation must be above 0 and at most 200 Hz (--rate)");
  check(width >= 64 && width <= 4096 && height >= 64 && height <= 4096,
        "the sides of simulated images must be 64 to 4096 pixels (--width, --height)");
  check(std::abs(calibration_error_mrad) <= 10.0,
        "the calibration's error must be -10 to 10 milliradians (--calibration-error)");
  image.Validate();
  check(movers >= 0 && movers <= 1000, "the number of movers must be 0 to 1000 (--movers)");
  check(
      movers_cover > 0.0 && movers_cover <= 0.5,
      "the share of the image that a mover fills must be above 0 and at most 0.5 (--movers-cover)");
  check(movers == 0 || !correspondences,
        "correspondences are those of a scene at rest, expected no movers");
  check(threads >= 0 && threads <= 1024, "the number of threads must be 0 (all) to 1024");
}

void Simulate(const SimulationOptions& options, const std::filesystem::path& directory,
              const std::function<void(int, int)>& progress) {
  options.Validate();
  const int threads = ThreadCount(options.threads);
  const vo::StereoRig rig = SimulationRig(options.width, options.height);
  const Flight flight = PlanFlight(options);
  PartialDirectory partial(directory, kSimulatedContent);
  const std::filesystem::path mav = partial.Sub("mav0");
  for (const char* name : {"cam0/data", "cam1/data", "imu0", "state_groundtruth_estimate0"}) {
    partial.Sub(std::string("mav0/") + name);
  }
  if (options.depth) {
    for (const char* name : {"cam0/depth", "cam1/depth"}) partial.Sub(std::string("mav0/") + name);
  }
  if (options.movers > 0) partial.Sub("mav0/cam0/movers");

  const int pairs = std::max(1, static_cast<int>(flight.duration_s * options.rate_hz + 1e-6));
  std::vector<int64_t> times(pairs);
  for (int i = 0; i < pairs; ++i) times[i] = TimeNs(i, options.rate_hz);
  const std::vector<int64_t> stamps = OnClock(times, flight.start_ns);
  const vo::StereoRig calibrated = WithRightTurned(rig, 1e-3 * options.calibration_error_mrad);
  for (int camera = 0; camera < 2; ++camera) {
    const std::filesystem::path folder = mav / ("cam" + std::to_string(camera));
    WriteAslCamera(folder / "sensor.yaml", calibrated, camera, options.rate_hz,
                   "made by gluevo simulate: " + flight.description + ", seed " +
                       std::to_string(options.seed));
    WriteAslImageList(folder / "data.csv", stamps);
  }
  WriteStates(mav, flight, times, Hash(options.seed, kImuStream));

  // A texel is what a pixel covers at 2 m, or at 1.2 m on boxes, which are passed nearer.
  RoomStyle style;
  style.texel_m = std::clamp(2.0 / rig.cameras[0].fx, 0.002, 0.02);
  style.box_texel_m = 0.6 * style.texel_m;
  const std::vector<Eigen::Vector3d> points = FlightPoints(flight);
  RoomPlan plan = PlanRoom(points, flight.margins);
  if (options.twins) {
    constexpr double kTwinM = 6.0;
    style.twin_m = kTwinM;
    const double parts = std::max(2.0, std::ceil((plan.high - plan.low).x() / kTwinM));
    plan.high.x() = plan.low.x() + parts * kTwinM;
  }
  const SimulatedWorld world = MakeRoom(Hash(options.seed, kWorldStream), plan, points, style,
                                        threads, {}, options.checkpoint);
  const std::vector<Mover> movers =
      MakeMovers(Hash(options.seed, kMoverStream), options.movers, options.movers_cover, flight,
                 rig, style.box_texel_m, threads, options.checkpoint);
  const Renderer renderer(rig, threads);
  const Sensor sensor(options.image);
  std::mutex progress_mutex;
  int done = 0;
  ParallelFor(2 * pairs, threads, [&](int i) {
    const int camera = i % 2;
    const double time = Seconds(times[i / 2]);
    const std::filesystem::path folder = mav / ("cam" + std::to_string(camera));
    const std::string stamp = std::to_string(stamps[i / 2]);
    const SimulatedWorld now = WorldAt(world, movers, time);
    const cv::Mat brightness = renderer.Render(
        now, camera, PosesOfExposure(flight.path, time, options.image.motion_blur_ms, rig));
    WriteImage(folder / "data" / (stamp + ".png"),
               sensor.Expose(brightness, sensor.Exposure(time, Hash(options.seed, kExposureStream)),
                             Hash(options.seed, kImageStream, i)));
    if (options.depth) {
      WriteImage(folder / "depth" / (stamp + ".tiff"),
                 renderer.Depth(now, camera, flight.path(time)));
    }
    if (!movers.empty() && camera == 0) {
      WriteImage(folder / "movers" / (stamp + ".png"),
                 renderer.MaskOfBoxes(now, camera, flight.path(time),
                                      static_cast<int>(world.boxes.size())));
    }
    const std::lock_guard<std::mutex> lock(progress_mutex);
    if (progress) progress(++done, 2 * pairs);
  });
  if (options.correspondences) {
    WriteCorrespondences(mav / "correspondences.h5", renderer, world, Poses(flight, times), stamps,
                         threads, options.checkpoint);
  }
  partial.Finish();
}

}  // namespace gluevo::simulation
