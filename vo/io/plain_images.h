#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

// Where the images of two cameras lie in a folder that is no published data set.
namespace gluevo::vo {

struct PlainImages {
  /// Of the left and the right camera; the same where one folder holds the images of both.
  std::array<std::filesystem::path, 2> folders;
  std::string note;  ///< Which folders were taken where others would do as well; else empty.
};

/// Two folders whose names differ in the side: left and right anywhere in the name, l and r as a
/// word of it, or 0 and 1, 1 and 2, 2 and 3 behind cam, camera, image, img, infra and the like, in
/// upper or lower case; or the folder itself where names of images tell left from right.
std::optional<PlainImages> FindPlainImages(const std::filesystem::path& root);

/// The images of both cameras. Throws Error where a camera has none.
std::array<std::vector<std::filesystem::path>, 2> ListPlainImages(const PlainImages& found);

}  // namespace gluevo::vo
