#include "gluevo/vo/io/output_directory.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "gluevo/nn/error.h"
#include "message_of.h"
#include "temporary_folder.h"

namespace gluevo::vo {
namespace {

namespace fs = std::filesystem;

TEST(OutputDirectory, IsMadeWithThoseAboveItAndStaysEmpty) {
  const TemporaryFolder folder;
  const fs::path made = folder.path() / "a" / "b";
  MakeOutputDirectory(made);
  EXPECT_TRUE(fs::is_directory(made));
  EXPECT_TRUE(fs::is_empty(made));
  EXPECT_NO_THROW(MakeOutputDirectory(made));
}

TEST(OutputDirectory, RefusesAFileInItsPlaceOrAboveIt) {
  const TemporaryFolder folder;
  const fs::path file = folder.path() / "file";
  std::ofstream(file) << "kept";
  EXPECT_THROW(MakeOutputDirectory(file), Error);
  EXPECT_THROW(MakeOutputDirectory(file / "below"), Error);
  EXPECT_EQ(fs::file_size(file), 4U);
}

TEST(OutputDirectory, SaysWhyANameIsNone) {
  const TemporaryFolder folder;
  const auto error_of = [](const fs::path& path) {
    return MessageOf([&] { MakeOutputDirectory(path); });
  };
  EXPECT_EQ(error_of(""), "the folder for output has no name");
  fs::create_symlink("nowhere", folder.path() / "link");
  EXPECT_NE(error_of(folder.path() / "link").find("link to what is not there"), std::string::npos);
}

TEST(OutputDirectory, RefusesAFolderInWhichNoFileCanBeMade) {
  // Nobody makes files there, not even root.
  EXPECT_THROW(MakeOutputDirectory("/proc/self"), Error);
}

TEST(OutputDirectory, GoesAgainWhereNothingWasPutIntoIt) {
  const TemporaryFolder folder;
  const fs::path path = folder.path() / "results";
  { const OutputDirectory unused(path); }
  EXPECT_FALSE(fs::exists(path));
  {
    const OutputDirectory used(path);
    std::ofstream(path / "trajectory.tum") << "0 0 0 0 0 0 0 1";
  }
  EXPECT_TRUE(fs::exists(path / "trajectory.tum"));
  fs::remove(path / "trajectory.tum");
  { const OutputDirectory not_ours(path); }
  EXPECT_TRUE(fs::exists(path));
}

TEST(OutputDirectory, IsOneProgramsAtATime) {
  const TemporaryFolder folder;
  const fs::path path = folder.path() / "results";
  {
    const OutputDirectory first(path);
    EXPECT_NE(MessageOf([&] { const OutputDirectory second(path); }).find("another program"),
              std::string::npos);
    EXPECT_NO_THROW(OutputDirectory(folder.path() / "others"));
  }
  EXPECT_NO_THROW(OutputDirectory{path});
}

}  // namespace
}  // namespace gluevo::vo
