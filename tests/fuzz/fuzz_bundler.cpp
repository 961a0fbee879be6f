// SPDX-License-Identifier: Apache-2.0
#include "relight/cameras/bundler_file.h"
#include "tests/fuzz/fuzz_files.h"

extern "C" int LLVMFuzzerTestOneInput(const unsigned char* data, std::size_t size) {
  using namespace relight;
  const auto& folder = fuzz::Written(data, size, {"list.txt", "bundle.out"});
  return fuzz::Survives([&] {
    return ReadBundler(folder / "bundle.out", fuzz::Photos(), UnknownPhotos::kLeaveOut);
  });
}
