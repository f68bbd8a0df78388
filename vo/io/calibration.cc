#include "gluevo/vo/io/calibration.h"

#include <algorithm>
#include <cctype>
#include <cmath>

#include "calibration_forms.h"
#include "foreign_input.h"
#include "gluevo/nn/error.h"
#include "gluevo/vo/io/whole_file.h"
#include "text_file.h"
#include "xml_file.h"
#include "yaml_file.h"

namespace gluevo::vo {
namespace {

namespace fs = std::filesystem;

// In the order in which they are recognised: the names of OpenCV's are the least particular.
constexpr const CalibrationForm* kForms[] = {&kKalibrForm,        &kOpenVinsForm, &kVinsFusionForm,
                                             &kOrbSlamForm,       &kBasaltForm,   &kEurocForm,
                                             &kRosCameraInfoForm, &kZedForm,      &kOpenCvForm};

const CalibrationForm* FormOf(const CalibrationFile& file) {
  const auto* const found =
      std::find_if(std::begin(kForms), std::end(kForms),
                   [&](const CalibrationForm* form) { return form->is(file); });
  return found != std::end(kForms) ? *found : nullptr;
}

std::string AcceptedForms() {
  std::string forms;
  for (const CalibrationForm* const form : kForms) {
    forms += (forms.empty() ? "" : "; ") + std::string(form->signs);
  }
  return forms;
}

[[noreturn]] void RefuseUnknown(const CalibrationFile& file) {
  const std::string what = file.syntax_error.empty()
                               ? file.path.string() + ": not a calibration that is known"
                               : file.syntax_error;
  throw Error(what + "; accepted are " + AcceptedForms());
}

// A form that any of the files has goes for all; its reader finds out which is which. Files are
// copied, never assigned: an assignment of YAML's nodes changes the tree that both share.
CalibrationInput WithFormFirst(const CalibrationInput& input) {
  const auto first =
      std::find_if(input.named.begin(), input.named.end(),
                   [](const CalibrationFile& file) { return FormOf(file) != nullptr; });
  if (first == input.named.end()) {
    RefuseUnknown(input.named.front());
  }
  CalibrationInput ordered{{}, input.open, input.image_size};
  ordered.named.reserve(input.named.size());
  ordered.named.push_back(*first);
  for (auto file = input.named.begin(); file != input.named.end(); ++file) {
    if (file != first) {
      ordered.named.push_back(*file);
    }
  }
  return ordered;
}

/// The rig with a size, be it only a guess.
StereoRig WithSize(StereoRig rig) {
  for (Camera& camera : rig.cameras) {
    if (camera.width == 0 && std::isfinite(camera.cx) && std::isfinite(camera.cy)) {
      constexpr double kLargest = 1e6;
      camera.width = static_cast<int>(std::clamp(2.0 * camera.cx, 1.0, kLargest));
      camera.height = static_cast<int>(std::clamp(2.0 * camera.cy, 1.0, kLargest));
    }
  }
  return rig;
}

void Check(const CalibrationInput& input, const std::string& what, Calibration& calibration) {
  for (Camera& camera : calibration.rig.cameras) {
    if (camera.width == 0 && input.image_size) {
      camera.width = (*input.image_size)[0];
      camera.height = (*input.image_size)[1];
    }
  }
  if (calibration.rig.cameras[0].width == 0) {
    calibration.notes.emplace_back("the size of the images is not in the file");
  }
  const StereoRig rig = WithSize(calibration.rig);
  rig.Validate(what);
  const std::vector<std::string> oddities = rig.Oddities();
  calibration.warnings.insert(calibration.warnings.end(), oddities.begin(), oddities.end());
}

std::optional<CalibrationFile> OpenFile(const fs::path& path) {
  std::error_code ignored;
  if (!fs::is_regular_file(path, ignored)) {
    return std::nullopt;
  }
  constexpr std::uintmax_t kLargest = 16 << 20;
  if (fs::file_size(path, ignored) > kLargest) {
    throw Error(path.string() + ": not a calibration: larger than 16 MiB");
  }
  return ParseCalibrationFile(path, ReadText(path));
}

// What of a folder's files is a calibration.
std::vector<CalibrationFile> FilesOfFolder(const fs::path& folder) {
  constexpr const char* kExtensions[] = {".yaml", ".yml", ".json", ".xml", ".conf"};
  std::vector<fs::path> paths;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
    const std::string extension = entry.path().extension().string();
    const bool is_text = std::find(std::begin(kExtensions), std::end(kExtensions), extension) !=
                         std::end(kExtensions);
    if (is_text && entry.is_regular_file() && !entry.path().filename().string().starts_with('.')) {
      paths.push_back(entry.path());
    }
  }
  std::sort(paths.begin(), paths.end());
  std::vector<CalibrationFile> files;
  for (const fs::path& path : paths) {
    auto file = OpenFile(path);
    if (file && FormOf(*file) != nullptr) {
      files.push_back(std::move(*file));
    }
  }
  for (const char* const camera : {"cam0", "left"}) {
    auto file = OpenFile(folder / camera / "sensor.yaml");
    if (file && FormOf(*file) != nullptr) {
      files.push_back(std::move(*file));
    }
  }
  return files;
}

bool Mentions(const Calibration& calibration, const fs::path& path) {
  const auto whole = [](const fs::path& file) { return fs::absolute(file).lexically_normal(); };
  return std::any_of(calibration.files.begin(), calibration.files.end(),
                     [&](const fs::path& file) { return whole(file) == whole(path); });
}

// The one calibration that the files of a folder make.
Calibration ReadFolder(const fs::path& folder, const CalibrationInput& settings) {
  std::vector<Calibration> found;
  std::string failure;
  for (CalibrationFile& file : FilesOfFolder(folder)) {
    const bool is_known = std::any_of(found.begin(), found.end(), [&](const Calibration& other) {
      return Mentions(other, file.path);
    });
    if (is_known) {
      continue;
    }
    try {
      CalibrationInput input = settings;
      input.named = {std::move(file)};
      found.push_back(ParseCalibration(input));
    } catch (const Error& error) {
      failure = failure.empty() ? error.what() : failure;
    }
  }
  if (found.size() > 1) {
    throw Error(folder.string() + ": several calibrations, " + found[0].files[0].string() +
                " and " + found[1].files[0].string() + ": name one of them");
  }
  if (found.empty()) {
    throw Error(failure.empty()
                    ? folder.string() + ": no calibration in it; accepted are " + AcceptedForms()
                    : failure);
  }
  return found[0];
}

// A second file where one holds all: another calibration is refused, what is none is passed over.
void CheckCount(const CalibrationForm& form, const CalibrationInput& input,
                Calibration& calibration) {
  if (input.named.size() <= form.most_files) {
    return;
  }
  const CalibrationFile& second = input.named[form.most_files];
  if (FormOf(second) != nullptr) {
    throw Error(second.path.string() + ": a second calibration beside " +
                input.named.front().path.string() +
                ", expected one file, which holds both cameras");
  }
  calibration.files.resize(form.most_files);
  calibration.notes.push_back(second.path.string() + ": not used, no calibration of cameras");
}

}  // namespace

CalibrationFile ParseCalibrationFile(fs::path path, std::string text) {
  CalibrationFile file{std::move(path), std::move(text), YAML::Node(), ""};
  try {
    const std::size_t first = file.text.find_first_not_of(" \t\r\n\xEF\xBB\xBF");
    const bool is_xml = first != std::string::npos && file.text[first] == '<';
    file.tree = is_xml ? ParseOpenCvXml(file.text.substr(first), file.path)
                       : ParseYaml(file.text, file.path);
  } catch (const Error& error) {
    const bool is_empty = file.text.find_first_not_of(" \t\r\n\xEF\xBB\xBF") == std::string::npos;
    const std::string what = is_empty ? "an empty file" : WhatBytesAre(file.text);
    file.syntax_error =
        what.empty() ? error.what() : file.path.string() + ": not a calibration: " + what;
  }
  return file;
}

Calibration ParseCalibration(const CalibrationInput& unordered) {
  const CalibrationInput input = WithFormFirst(unordered);
  const CalibrationForm& form = *FormOf(input.named.front());
  Calibration calibration;
  calibration.tool = form.tool;
  for (const CalibrationFile& file : input.named) {
    calibration.files.push_back(file.path);
  }
  const std::string& path = input.named.front().path.string();
  try {
    CheckCount(form, input, calibration);
    form.read(input, calibration);
    Check(input, path, calibration);
  } catch (const YAML::Exception& error) {
    throw Error(path + ": " + error.msg + " (read as " + calibration.tool + ")");
  } catch (const Error& error) {
    throw Error(std::string(error.what()) + " (read as " + calibration.tool + ")");
  }
  return calibration;
}

Calibration ReadCalibration(const std::vector<fs::path>& files,
                            const std::optional<std::array<int, 2>>& image_size) {
  constexpr std::size_t kMostFiles = 2;
  if (files.empty() || files.size() > kMostFiles) {
    throw Error("calibration: " + std::to_string(files.size()) + " files, expected one or two");
  }
  CalibrationInput input{{}, &OpenFile, image_size};
  if (files.size() == 1 && fs::is_directory(files[0])) {
    return ReadFolder(files[0], input);
  }
  for (const fs::path& path : files) {
    auto file = OpenFile(path);
    if (!file) {
      throw Error(path.string() + (fs::is_directory(path)
                                       ? ": a folder, expected the file of one camera beside that "
                                         "of the other one"
                                       : ": " + WhyNoFile(path) + " (calibration)"));
    }
    input.named.push_back(std::move(*file));
  }
  std::error_code ignored;
  if (files.size() == kMostFiles && fs::equivalent(files[0], files[1], ignored)) {
    throw Error(files[1].string() +
                ": the same file twice, expected the calibration of each camera");
  }
  return ParseCalibration(input);
}

CalibrationFile OpenBeside(const CalibrationInput& input, const fs::path& path,
                           const fs::path& asked_by, Calibration& calibration) {
  auto file = input.open(path);
  if (!file) {
    throw Error(asked_by.string() + ": names " + path.string() + ", which is not there");
  }
  if (!file->syntax_error.empty()) {
    throw Error(file->syntax_error);
  }
  calibration.files.push_back(path);
  return *file;
}

}  // namespace gluevo::vo
