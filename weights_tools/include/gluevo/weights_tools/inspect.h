#pragma once

#include <filesystem>
#include <string>

namespace gluevo::weights_tools {

/// What a weights file of any form is, for people: file, checksum, form, the networks in it (or why
/// there is none), source, licence, and a table of the tensors as the file has them, with shapes
/// and ranges of values. Ends with a line feed. Throws Error for a file that cannot be read.
std::string InspectionText(const std::filesystem::path& path);

/// The same as a JSON object: "file", "sha256", "form", "networks" (a list; empty where there is
/// none, with "problem" saying why), "architecture" (the first of them, or null), "source",
/// "licence" and "note" (null where the file does not tell), "metadata", "parameters", and
/// "tensors" as a list of {"name", "shape", "minimum", "maximum"} in the order of names. Ends with
/// a line feed. Throws Error for a file that cannot be read.
std::string InspectionJson(const std::filesystem::path& path);

}  // namespace gluevo::weights_tools
