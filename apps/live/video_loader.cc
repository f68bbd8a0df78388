#include <dlfcn.h>

#include <filesystem>
#include <string>

#include "gluevo/nn/error.h"
#include "video_device.h"

namespace gluevo::apps {
namespace {

using OpenFunction = VideoDevice* (*)(const char*);

// Beside the program, where it is built, or where it is installed.
OpenFunction LoadModule() {
  std::error_code code;
  const std::filesystem::path folder =
      std::filesystem::read_symlink("/proc/self/exe", code).parent_path();
  std::string why;
  for (const std::filesystem::path& file :
       {folder / GLUEVO_VIDEO_MODULE, folder / GLUEVO_VIDEO_INSTALLED / GLUEVO_VIDEO_MODULE}) {
    void* const module = dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL);
    if (module != nullptr) {
      // As POSIX has it.
      return reinterpret_cast<OpenFunction>(dlsym(module, "GluevoOpenVideo"));
    }
    why = std::filesystem::exists(file, code) || why.empty() ? dlerror() : why;
  }
  throw Error(
      "cameras need " GLUEVO_VIDEO_MODULE " and OpenCV's videoio, which cannot be loaded: " + why);
}

}  // namespace

std::unique_ptr<VideoDevice> OpenVideoDevice(const std::string& source) {
  static const OpenFunction open = LoadModule();
  return std::unique_ptr<VideoDevice>(open(source.c_str()));
}

}  // namespace gluevo::apps
