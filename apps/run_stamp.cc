#include "run_stamp.h"

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <iomanip>
#include <sstream>
#include <vector>

#include "gluevo/nn/error.h"
#include "gluevo/nn/input_file.h"
#include "gluevo/nn/output_file.h"
#include "gluevo/nn/weights_folder.h"
#include "gluevo/vo/io/dataset.h"
#include "json_text.h"

namespace gluevo::apps {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr const char* kStamp = "stamp.json";
constexpr const char* kResults[] = {"metrics.json", "trajectory.tum"};

std::string Checksum(const fs::path& path) {
  const nn::InputFile file = nn::ReadInputFile(path);
  return nn::Sha256(file.data.get(), file.size);
}

std::string ChecksumOfText(const std::string& text) { return nn::Sha256(text.data(), text.size()); }

// Of a file's bytes, or of those of all files in a folder.
std::string ChecksumOfInput(const fs::path& path) {
  if (!fs::is_directory(path)) {
    return Checksum(path);
  }
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(path)) {
    if (entry.is_regular_file()) {
      files.push_back(entry.path());
    }
  }
  std::sort(files.begin(), files.end());
  std::string text;
  for (const fs::path& file : files) {
    text += file.filename().string() + ' ' + Checksum(file) + '\n';
  }
  return ChecksumOfText(text);
}

std::ostream& operator<<(std::ostream& out, const vo::Rigid3& pose) {
  return out << pose.rotation.coeffs().transpose() << ' ' << pose.translation.transpose() << '\n';
}

std::string ChecksumOfDataset(const vo::Dataset& dataset) {
  std::ostringstream text;
  text << std::setprecision(17);
  for (const vo::Camera& camera : dataset.rig.cameras) {
    text << camera.width << ' ' << camera.height << ' ' << camera.fx << ' ' << camera.fy << ' '
         << camera.cx << ' ' << camera.cy << ' ' << static_cast<int>(camera.distortion);
    for (const double coefficient : camera.coefficients) {
      text << ' ' << coefficient;
    }
    text << '\n';
  }
  text << dataset.rig.body_from_cam[0] << dataset.rig.body_from_cam[1];
  for (const vo::Dataset::Entry& entry : dataset.entries) {
    text << entry.timestamp_ns;
    for (const fs::path& image : entry.images) {
      text << ' ' << image.filename().string() << ' ' << fs::file_size(image) << ' '
           << fs::last_write_time(image).time_since_epoch().count();
    }
    text << '\n';
  }
  if (dataset.groundtruth) {
    for (const vo::StampedPose& pose : *dataset.groundtruth) {
      text << pose.timestamp_ns << ' ' << pose.world_from_body;
    }
  }
  return ChecksumOfText(text.str());
}

bool HasOption(const PlannedRun& run, const std::string& name, const std::string& value) {
  const auto found = run.options.find(name);
  return found != run.options.end() && found->second == value;
}

Json ChecksumsOfResults(const fs::path& folder) {
  Json checksums;
  for (const char* const name : kResults) {
    checksums[name] = Checksum(folder / name);
  }
  return checksums;
}

}  // namespace

std::string ProgramChecksum() { return Checksum("/proc/self/exe"); }

Json DescribeInputs(const PlannedRun& run, const std::string& program_checksum) {
  Json inputs;
  inputs["program"] = program_checksum;
  const char* const isa = std::getenv("GLUEVO_ISA");
  inputs["isa"] = isa != nullptr ? isa : "";
  inputs["data"] = ChecksumOfDataset(OpenDatasetOf(run));
  inputs["options"] = Json::object();
  for (const auto& [name, value] : run.options) {
    inputs["options"][name] = NamesInput(name, value) ? ChecksumOfInput(value) : value;
  }
  // Weights that no option need name.
  if (const fs::path own = nn::UserWeightsFolder();
      (HasOption(run, "features", "aliked") || HasOption(run, "matcher", "lightglue")) &&
      fs::is_directory(own)) {
    inputs["own_weights"] = ChecksumOfInput(own);
  }
  return inputs;
}

void WriteStamp(const fs::path& folder, const Json& inputs) {
  const Json stamp = {{"inputs", inputs}, {"results", ChecksumsOfResults(folder)}};
  nn::WriteWholeFile(folder / kStamp, [&](std::ostream& out) { out << JsonText(stamp); });
}

bool HasStamp(const fs::path& folder, const Json& inputs) {
  std::ifstream stream(folder / kStamp);
  const Json stamp = Json::parse(stream, nullptr, /*allow_exceptions=*/false);
  if (!stamp.is_object() || !stamp.contains("inputs") || !stamp.contains("results") ||
      stamp["inputs"] != Json::parse(JsonText(inputs))) {
    return false;
  }
  try {
    return stamp["results"] == ChecksumsOfResults(folder);
  } catch (const Error&) {
    return false;  // A result is gone.
  }
}

void RemoveResults(const fs::path& folder) {
  for (const char* const name :
       {kStamp, "metrics.json", "trajectory.tum", "trajectory_optimized.tum", "imu_rate.tum",
        "keyframes.tum", "covariance.csv", "report.html", kRunLog}) {
    fs::remove(folder / name);
  }
}

}  // namespace gluevo::apps
