#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "gluevo/vo/core/frame_result.h"

namespace gluevo::apps {

/// Writes how good each pose is, a line a frame; docs/OUTPUTS.md has the columns. `body_frame` is
/// what the poses are of. Throws Error where the file cannot be written.
void WriteCovariances(const std::filesystem::path& path, const std::vector<vo::FrameResult>& frames,
                      const std::string& body_frame);

}  // namespace gluevo::apps
