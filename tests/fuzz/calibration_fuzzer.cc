#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "calibration_forms.h"
#include "gluevo/nn/error.h"

namespace {

using namespace gluevo;

/// The input is one to three files with a line of %%% between them: the named one, and what is
/// there under any other name, in turn.
std::vector<std::string> Split(const std::string& input) {
  constexpr std::string_view kBetween = "\n%%%\n";
  std::vector<std::string> texts;
  std::size_t begin = 0;
  for (std::size_t at = input.find(kBetween); at != std::string::npos && texts.size() < 2;
       at = input.find(kBetween, begin)) {
    texts.push_back(input.substr(begin, at - begin));
    begin = at + kBetween.size();
  }
  texts.push_back(input.substr(begin));
  return texts;
}

void Parse(const std::vector<std::string>& texts, bool both_named) {
  vo::CalibrationInput input;
  input.named.push_back(vo::ParseCalibrationFile("left/intrinsics.yml", texts[0]));
  if (both_named && texts.size() > 1) {
    input.named.push_back(vo::ParseCalibrationFile("right/intrinsics.yml", texts[1]));
  }
  std::size_t next = 1;
  input.open = [&](const std::filesystem::path& path) -> std::optional<vo::CalibrationFile> {
    if (next >= texts.size()) {
      return std::nullopt;
    }
    return vo::ParseCalibrationFile(path, texts[next++]);
  };
  input.image_size = {752, 480};
  const vo::Calibration calibration = vo::ParseCalibration(input);
  // What was accepted can be used and written.
  for (const vo::Camera& camera : calibration.rig.cameras) {
    camera.Distort(camera.Undistort({10.0, 20.0}));
  }
  vo::SensorYamlText(calibration.rig, 1);
  vo::KalibrText(calibration.rig);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, std::size_t size) {
  const std::vector<std::string> texts =
      Split(std::string(reinterpret_cast<const char*>(data), size));
  for (const bool both_named : {false, true}) {
    try {
      Parse(texts, both_named);
    } catch (const Error&) {  // The one answer that a broken file may get.
    }
  }
  return 0;
}
