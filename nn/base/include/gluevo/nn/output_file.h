#pragma once

#include <filesystem>
#include <functional>
#include <ostream>

namespace gluevo::nn {

/// Where a file is to be put so that it is found at `path`: there, or where a link at `path` points
/// to. Throws Error where something is there that is no file: a file that takes the place of a
/// device would take it from every program.
std::filesystem::path PlaceForFile(const std::filesystem::path& path);

/// Writes a file that is there whole or not at all: `write` fills a file beside `path`, which then
/// takes the place of `path`. Where anything fails, `write` throwing included, what was at `path`
/// before is untouched and nothing is left beside it. Throws Error where it cannot be written,
/// and as PlaceForFile does.
void WriteWholeFile(const std::filesystem::path& path,
                    const std::function<void(std::ostream&)>& write);

}  // namespace gluevo::nn
