// SPDX-License-Identifier: Apache-2.0
// Which blocks of a photo a picture wants, by a small picture of the same ground.
#include <algorithm>
#include <vector>

#include "shade/deferred.h"

namespace terray {

void DeferredShader::prepareUse(PhotoUse& use) const {
    if (photoFilter_)
        photoFilter_->prepare(use);
    else
        use.clear(0);
}

void DeferredShader::scoutPhoto(const RayFrame& rays, int pixels, PhotoUse& use) const {
    if (!photoFilter_) return;
    const float share = sampleShare_ / static_cast<float>(pixels);
    const TerrainInfo& info = terrain_.info();
    const GroundSampler sampler(cut_, info, rays, share, true);
    const PhotoMap map(info.worldFromLattice, photo_.worldFromPixel(), static_cast<double>(share));
    const ImageTile all{0, 0, rays.camera().width, rays.camera().height};
    std::vector<Ray> batch;
    std::vector<Hit> hits;
    for (size_t first = 0; first < all.pixelCount(); first += kBatch) {
        batch.clear();
        for (size_t k = first; k < std::min(first + kBatch, all.pixelCount()); ++k)
            batch.push_back(
                rays.rayThrough(static_cast<double>(k % static_cast<size_t>(all.width)) + 0.5,
                                static_cast<double>(k / static_cast<size_t>(all.width)) + 0.5));
        hits.resize(batch.size());
        TraceCounters counters;
        firstHits(cut_, batch, hits, counters);
        const HitBatch found(hits);
        if (!found.some) continue;
        ViewBatch view;
        view.setPixels(rays.camera(), all, {0.5, 0.5}, first);
        sampler.lookThrough(view);
        GroundBatch ground;
        sampler.at(found, view, ground);
        PhotoFeet feet;
        PhotoBatch unused;
        map.place(ground, feet);
        photoFilter_->at(feet, unused, use);
    }
}

}  // namespace terray
