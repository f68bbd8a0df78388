#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "file_size_limit.h"
#include "gluevo/nn/error.h"
#include "gluevo/vo/io/hdf5_file.h"
#include "temporary_folder.h"

namespace gluevo::vo::internal {
namespace {

namespace fs = std::filesystem;

// Enough datasets that HDF5's cache of metadata overflows, too.
void Fill(H5OutputFile* file, int groups) {
  const std::vector<double> values(2000, 1.5);
  for (int i = 0; i < groups; ++i) {
    const std::string group = "group" + std::to_string(i);
    file->MakeGroup(group, "values");
    file->Write(group + "/values", {1000, 2}, values.data());
    file->WriteTexts(group, {{"name", std::string(300, 'x')}});
  }
}

std::string FailureOf(const fs::path& path, int groups) {
  try {
    H5OutputFile file(path);
    Fill(&file, groups);
    file.Finish();
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

std::size_t Files(const fs::path& folder) {
  return static_cast<std::size_t>(std::distance(fs::directory_iterator(folder), {}));
}

TEST(Hdf5OutputTest, AFullDiskIsAnErrorThatHdf5Survives) {
  const TemporaryFolder folder;
  const fs::path path = folder.path() / "file.h5";
  for (const rlim_t bytes : {0, 100, 2000, 20'000, 1'000'000, 4'000'000}) {
    SCOPED_TRACE(bytes);
    const FileSizeLimit limit(bytes);
    const std::string failure = FailureOf(path, 300);
    EXPECT_TRUE(failure.starts_with(path.string() + ": ")) << failure;
    EXPECT_TRUE(failure.ends_with("cannot be written: File too large")) << failure;
    EXPECT_EQ(Files(folder.path()), 0U);
  }
  // The next file is none the worse.
  EXPECT_EQ(FailureOf(path, 300), "");
  const H5InputFile file(path);
  EXPECT_EQ(file.GroupsWith("values").size(), 300U);
  EXPECT_EQ(file.ReadDoubles("group299/values").back(), 1.5);
}

// HDF5 used to crash at the program's end.
TEST(Hdf5OutputDeathTest, AProgramEndsInOrderAfterAFullDisk) {
  ::testing::FLAGS_gtest_death_test_style = "threadsafe";
  const TemporaryFolder folder;
  EXPECT_EXIT(
      {
        const FileSizeLimit limit(60'000);
        const std::string failure = FailureOf(folder.path() / "file.h5", 300);
        std::exit(failure.empty() ? 2 : 1);
      },
      ::testing::ExitedWithCode(1), "");
}

TEST(Hdf5OutputTest, TheSameDataGiveTheSameBytes) {
  const TemporaryFolder folder;
  std::vector<std::string> bytes;
  for (const char* const name : {"first.h5", "second.h5"}) {
    ASSERT_EQ(FailureOf(folder.path() / name, 20), "");
    std::ifstream stream(folder.path() / name, std::ios::binary);
    bytes.emplace_back(std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>());
  }
  EXPECT_EQ(bytes[0], bytes[1]);
  EXPECT_EQ(bytes[0].substr(0, 8), "\x89HDF\r\n\x1a\n");
}

}  // namespace
}  // namespace gluevo::vo::internal
