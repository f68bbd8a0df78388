#include "trajectory_oddities.h"

#include <algorithm>
#include <cctype>
#include <optional>
#include <string>

#include "gluevo/nn/error.h"

namespace gluevo::vo {

bool IsNoValue(std::string_view field) {
  std::string word = Lowercase(field);
  if (word.starts_with('-') || word.starts_with('+')) {
    word.erase(0, 1);
  }
  return word.empty() || word.starts_with("nan") || word == "inf" || word == "infinity" ||
         word.starts_with("1.#") || word == "none" || word == "null";
}

bool IsWithoutPose(const std::vector<std::string_view>& fields) {
  return fields.size() == 1 ||
         std::any_of(fields.begin(), fields.end(), [](std::string_view field) {
           return !field.empty() && std::isalpha(static_cast<unsigned char>(field.front())) != 0;
         });
}

double ParseField(const std::filesystem::path& path, const TextLine& line, std::string_view field) {
  const std::optional<double> value = ParseNumber(field);
  if (!value) {
    throw Error(At(path, line) + ": " + Quoted(field) + " is not a finite number");
  }
  return *value;
}

}  // namespace gluevo::vo
