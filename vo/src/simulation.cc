#include "gluevo/vo/simulation.h"

#include <algorithm>
#include <cmath>
#include <mutex>
#include <opencv2/imgcodecs.hpp>
#include <set>

#include "gluevo/nn/error.h"
#include "parallel_for.h"
#include "simulation_asl.h"
#include "simulation_imu.h"
#include "simulation_path.h"
#include "simulation_random.h"
#include "simulation_renderer.h"
#include "simulation_world.h"

namespace gluevo::vo {
namespace {

/// As large as real clocks', so that whatever keeps times in too few digits shows.
constexpr int64_t kStartNs = 1'500'000'000'000'000'000;

int64_t TimeNs(int64_t index, double rate_hz) {
  return kStartNs + std::llround(static_cast<double>(index) * 1e9 / rate_hz);
}

double Seconds(int64_t time_ns) { return static_cast<double>(time_ns - kStartNs) * 1e-9; }

/// The streams of randomness that a seed feeds.
enum Stream : uint64_t { kWorldStream = 1, kImuStream = 2, kImageStream = 3 };

std::vector<Eigen::Vector3d> PathPoints(const SimulationPath& path, double duration_s) {
  std::vector<Eigen::Vector3d> points;
  constexpr double kStepS = 0.1;
  for (double time = 0.0; time < duration_s + kStepS; time += kStepS) {
    points.push_back(path(time).translation);
  }
  return points;
}

void WritePng(const std::filesystem::path& file, const cv::Mat& image) {
  bool written = false;
  try {
    // Noise hardly compresses: level 1 gives the size of the default at a third of its time.
    written = cv::imwrite(file.string(), image, {cv::IMWRITE_PNG_COMPRESSION, 1});
  } catch (const cv::Exception&) {
    written = false;
  }
  if (!written) throw Error(file.string() + ": cannot be written");
}

/// A new folder that takes its name when it is whole, and vanishes otherwise.
class PartialDirectory {
 public:
  explicit PartialDirectory(const std::filesystem::path& directory)
      : directory_(directory), part_(directory.string() + ".part") {
    for (const std::filesystem::path& path : {directory_, part_}) {
      if (std::filesystem::exists(path)) {
        throw Error(path.string() + ": exists already, expected the name of a new folder");
      }
    }
    Make(part_);
  }
  PartialDirectory(const PartialDirectory&) = delete;
  PartialDirectory& operator=(const PartialDirectory&) = delete;
  ~PartialDirectory() {
    std::error_code ignored;
    if (!whole_) std::filesystem::remove_all(part_, ignored);
  }

  /// A folder below, made with its parents.
  std::filesystem::path Sub(const std::string& name) const {
    Make(part_ / name);
    return part_ / name;
  }
  void Finish() {
    std::error_code error;
    std::filesystem::rename(part_, directory_, error);
    if (error) throw Error(directory_.string() + ": cannot be made: " + error.message());
    whole_ = true;
  }

 private:
  static void Make(const std::filesystem::path& path) {
    std::error_code error;
    std::filesystem::create_directories(path, error);
    if (error) throw Error(path.string() + ": cannot be made: " + error.message());
  }

  std::filesystem::path directory_;
  std::filesystem::path part_;
  bool whole_ = false;
};

void WriteStates(const std::filesystem::path& mav, const SimulationPath& path,
                 const std::vector<int64_t>& image_times, uint64_t seed) {
  const int imu_count =
      static_cast<int>(std::ceil(Seconds(image_times.back()) * kImuRateHz - 1e-6)) + 1;
  const ImuNoise noise;
  const std::vector<ImuSample> samples = SimulateImu(path, imu_count, noise, seed);
  std::vector<int64_t> imu_times(samples.size());
  for (int i = 0; i < imu_count; ++i) imu_times[i] = TimeNs(i, kImuRateHz);
  WriteAslImu(mav / "imu0" / "sensor.yaml", noise);
  WriteAslImuSamples(mav / "imu0" / "data.csv", imu_times, samples);

  std::set<int64_t> times(imu_times.begin(), imu_times.end());
  times.insert(image_times.begin(), image_times.end());
  std::vector<AslState> states;
  for (const int64_t time : times) {
    const auto next = std::upper_bound(imu_times.begin(), imu_times.end(), time);
    const ImuSample& sample = samples[std::max<std::ptrdiff_t>(0, next - imu_times.begin() - 1)];
    states.push_back(
        {time, MotionAt(path, Seconds(time)), sample.gyroscope_bias, sample.accelerometer_bias});
  }
  WriteAslGroundtruth(mav / "state_groundtruth_estimate0" / "data.csv", states);
}

}  // namespace

void SimulationOptions::Validate() const {
  MakeSimulationPath(path);
  const auto check = [](bool good, const std::string& what) {
    if (!good) throw Error(what);
  };
  check(duration_s > 0.0 && duration_s <= 3600.0,
        "the duration of a simulation must be above 0 and at most 3600 s");
  check(rate_hz > 0.0 && rate_hz <= 200.0,
        "the rate of a simulation must be above 0 and at most 200 Hz");
  check(width >= 64 && width <= 4096 && height >= 64 && height <= 4096,
        "the sides of simulated images must be 64 to 4096 pixels");
  check(noise >= 0.0 && noise <= 100.0, "the noise of a simulation must be 0 to 100 gray levels");
  check(threads >= 0 && threads <= 1024, "the number of threads must be 0 (all) to 1024");
}

void Simulate(const SimulationOptions& options, const std::filesystem::path& directory,
              const std::function<void(int, int)>& progress) {
  options.Validate();
  const int threads = ThreadCount(options.threads);
  const StereoRig rig = SimulationRig(options.width, options.height);
  const SimulationPath path = MakeSimulationPath(options.path);
  // A trailing slash would put ".part" inside the folder.
  PartialDirectory partial((directory / "").parent_path());
  const std::filesystem::path mav = partial.Sub("mav0");
  for (const char* name : {"cam0/data", "cam1/data", "imu0", "state_groundtruth_estimate0"}) {
    partial.Sub(std::string("mav0/") + name);
  }

  const int pairs = std::max(1, static_cast<int>(options.duration_s * options.rate_hz + 1e-6));
  std::vector<int64_t> times(pairs);
  for (int i = 0; i < pairs; ++i) times[i] = TimeNs(i, options.rate_hz);
  for (int camera = 0; camera < 2; ++camera) {
    const std::filesystem::path folder = mav / ("cam" + std::to_string(camera));
    WriteAslCamera(
        folder / "sensor.yaml", rig, camera, options.rate_hz,
        "made by gluevo simulate: path " + options.path + ", seed " + std::to_string(options.seed));
    WriteAslImageList(folder / "data.csv", times);
  }
  WriteStates(mav, path, times, Hash(options.seed, kImuStream));

  // A texel is what a pixel covers at 2 m.
  const double texel_m = 2.0 / rig.cameras[0].fx;
  const SimulatedWorld world =
      MakeHall(Hash(options.seed, kWorldStream), PathPoints(path, options.duration_s),
               std::clamp(texel_m, 0.002, 0.02), threads);
  const Renderer renderer(rig, world, options.noise, threads);
  std::mutex progress_mutex;
  int done = 0;
  ParallelFor(2 * pairs, threads, [&](int i) {
    const int camera = i % 2;
    const int64_t time = times[i / 2];
    const cv::Mat image =
        renderer.Render(camera, path(Seconds(time)), Hash(options.seed, kImageStream, i));
    WritePng(mav / ("cam" + std::to_string(camera)) / "data" / (std::to_string(time) + ".png"),
             image);
    const std::lock_guard<std::mutex> lock(progress_mutex);
    if (progress) progress(++done, 2 * pairs);
  });
  partial.Finish();
}

}  // namespace gluevo::vo
