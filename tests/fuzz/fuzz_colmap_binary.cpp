// SPDX-License-Identifier: Apache-2.0
#include "relight/cameras/colmap_model.h"
#include "tests/fuzz/fuzz_files.h"

extern "C" int LLVMFuzzerTestOneInput(const unsigned char* data, std::size_t size) {
  using namespace relight;
  const auto& folder =
      fuzz::Written(data, size, {"cameras.bin", "images.bin", "points3D.bin"});
  return fuzz::Survives([&] { return ReadColmap(folder.Path()); });
}
