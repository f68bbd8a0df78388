#pragma once

#include <filesystem>
#include <functional>
#include <ostream>

namespace gluevo::nn {

/// Writes a file that is there whole or not at all: `write` fills a file beside `path`, which then
/// takes the place of `path`. Where anything fails, `write` throwing included, what was at `path`
/// before is untouched and nothing is left beside it. Throws Error where it cannot be written.
void WriteWholeFile(const std::filesystem::path& path,
                    const std::function<void(std::ostream&)>& write);

}  // namespace gluevo::nn
