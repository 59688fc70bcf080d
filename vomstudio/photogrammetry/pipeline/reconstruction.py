"""Reconstruction of a textured model from a folder of photos in resumable stages."""

from __future__ import annotations

import contextlib
import os
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

from vomstudio.core.errors import InputError, TargetError
from vomstudio.core.findings import Finding, to_json_list
from vomstudio.core.progress import Executor, Progress, ResumedProgress
from vomstudio.core.version import __version__
from vomstudio.core.words import tr
from vomstudio.geometry.cloud import PointCloud
from vomstudio.io.models.reconstruction_file import WORK
from vomstudio.photogrammetry.align.scene_check import check_scene
from vomstudio.photogrammetry.base.background import find_rock, propose_region
from vomstudio.photogrammetry.base.checkpoints import (
    Checkpoints,
    StageFolder,
    make_key,
    write_atomically,
)
from vomstudio.photogrammetry.base.region import Region
from vomstudio.photogrammetry.base.scene import SparseScene
from vomstudio.photogrammetry.base.settings import PipelineSettings
from vomstudio.photogrammetry.base.stage_folders import FEATURES
from vomstudio.photogrammetry.georeferencing.pose_errors import pose_errors
from vomstudio.photogrammetry.pipeline import report_data
from vomstudio.photogrammetry.pipeline.gpu_depths import choose_device, compute_gpu_depths
from vomstudio.photogrammetry.pipeline.outputs import (
    Outputs,
    claim_folder,
    lock_folder,
    report_disk_errors,
)
from vomstudio.photogrammetry.pipeline.photo_input import (
    ControlTables,
    OriginalPhoto,
    alignment_facts,
    photo_hash,
    read_bytes,
    read_tables,
    usable_photos,
)
from vomstudio.photogrammetry.pipeline.photo_results import (
    PhotoResults,
    load_cloud,
    load_mesh,
    load_result,
    load_undistorted,
    save_cloud,
    save_mesh,
    save_undistorted,
)
from vomstudio.photogrammetry.pipeline.reused_depths import DepthInputs, EarlierDepthMaps
from vomstudio.photogrammetry.pipeline.stage_log import StageLog
from vomstudio.photogrammetry.pipeline.written_models import (
    write_camera_files,
    write_json,
    write_models,
    write_registrations,
)

if TYPE_CHECKING:
    from vomstudio.geometry.mesh import Mesh
    from vomstudio.io.photos.reading import PhotoFolder
    from vomstudio.photogrammetry.align.alignment import Alignment
    from vomstudio.photogrammetry.dense.depthmaps import DepthMap
    from vomstudio.photogrammetry.dense.pairs import DepthMapPlans
    from vomstudio.photogrammetry.dense.undistortion import UndistortedPhoto

Item = TypeVar("Item")
Result = TypeVar("Result")

_CLOUD_FILE, _MESH_FILE = "cloud.npz", "mesh.npz"
# Stage that stores a decision for resumed runs.
_SIZE_STAGE = "size"


def reconstruct(
    folder: Path,
    out: Path,
    settings: PipelineSettings,
    executor: Executor,
    progress: Progress,
    masks: Mapping[str, Path] | None = None,
) -> dict[str, Any]:
    """Reconstruct a model from the photos in `folder`, resuming a previous run.

    Parameters
    ----------
    folder, out : Path
    settings : PipelineSettings
    executor : Executor
    progress : Progress
    masks : mapping, optional
        Mask of each photo. If None, the masks beside the photos are used.

    Returns
    -------
    dict
        The object that CLI.md specifies for `reconstruct`, with additional data for the report. It
        is also written to `reconstruction.json`.

    Raises
    ------
    InputError
        If the photos cannot be used.
    GeometryError
        If a stage cannot compute its result, or the requested device is not available.
    TargetError
        If the results cannot be written to the disk.
    Cancelled
    """
    tables = read_tables(settings)
    photos = usable_photos(folder, settings, tables, progress, masks)
    outputs = claim_folder(out)
    with lock_folder(outputs), report_disk_errors(outputs.folder):
        run = _Run(photos, tables, outputs, settings, executor, StageLog(outputs.log, progress))
        try:
            return run.run_all_stages()
        finally:
            run.pause()


@dataclass(frozen=True)
class _RegisteredScene:
    scene: SparseScene
    registration: dict[str, Any]
    stage: StageFolder


class _Run:
    def __init__(
        self,
        photos: PhotoFolder,
        tables: ControlTables,
        outputs: Outputs,
        settings: PipelineSettings,
        executor: Executor,
        log: StageLog,
    ) -> None:
        self.photos, self.folder, self.outputs = photos, photos.folder, outputs
        self.tables = tables
        self.settings, self.executor, self.log = settings, executor, log
        self.device = choose_device(settings)
        self.region = Region.of(settings.region)
        # Without a region, the keys of dependent stages do not change.
        self.region_key = [tuple(settings.region)] if settings.region else []
        self.checkpoints = Checkpoints(outputs.folder / WORK)
        self.checkpoints.remove_partial_files()

    def run_all_stages(self) -> dict[str, Any]:
        self.log.log(f"VOM Studio {__version__}, {self.settings.to_dict()}")
        self._store_request()
        photos = self._check_photos()
        alignment, aligned = self._align(photos)
        # The alignment takes hours, so write it before anything can fail, and again once it is
        # registered.
        write_camera_files(self.outputs, self.folder, alignment, alignment.parts[0])
        alignment, aligned = self._join(alignment, aligned)
        placed_scene = self._place(alignment, photos, aligned)
        self.rock = find_rock(placed_scene.scene)
        self.has_background = self.region is None and self.rock.has_background
        self.is_trimmed = self.has_background and not self.settings.keep_background
        if self.has_background:
            code = "background.left-out" if self.is_trimmed else "background.kept"
            share_percent = 100 * self.rock.background_share
            self.log.note(Finding(code, share_percent=share_percent, factor=self.rock.factor))
        self.pose_errors = pose_errors(placed_scene.scene)
        write_camera_files(
            self.outputs, self.folder, alignment, placed_scene.scene, self.rock, self.pose_errors
        )
        undistorted, flat_stage = self._undistort(placed_scene, photos)
        pairs, maps, depth_stage = self._depths(placed_scene.scene, undistorted, flat_stage)
        cloud, fused_stage = self._fuse(placed_scene.scene, pairs, undistorted, maps, depth_stage)
        mesh, surface_stage = self._surface(cloud, fused_stage)
        textured_mesh, texture_stage = self._texture(mesh, placed_scene, photos, surface_stage)
        write_models(self.outputs, placed_scene.scene, cloud, textured_mesh, self.log)
        return self._finish(photos, alignment, placed_scene, cloud, textured_mesh, texture_stage)

    def pause(self) -> None:
        self.log.end_stage()
        for stage in self.checkpoints.stages:
            with contextlib.suppress(TargetError):
                stage.pause()

    # ------------------------------------------------------------------------------------------
    def _check_photos(self) -> PhotoFolder:
        photo_folder = self.photos
        for name, reason in photo_folder.skipped:
            self.log.note(Finding("photo.left-out", photo=name, reason=reason))
        for warning in photo_folder.warnings:
            self.log.note(warning)
        self.hashes: dict[str, str] = {}
        self.log.stage(tr("Checking photos"), len(photo_folder.photos))
        for number, photo in enumerate(photo_folder.photos):
            self.log.step(number)
            self.hashes[photo.name] = photo_hash(photo)
        return photo_folder

    def _align(self, photos: PhotoFolder) -> tuple[Alignment, StageFolder]:
        from vomstudio.photogrammetry.align.alignment import Alignment, AlignmentOptions, align

        size, seed = self.settings.quality_sizes.align_px, self.settings.seed
        stage = self.checkpoints.stage(
            "alignment",
            report_data.versions("pycolmap"),
            size,
            seed,
            self.hashes,
            alignment_facts(photos.photos),
        )
        if not stage.is_done:
            options = AlignmentOptions(max_size=size, seed=seed, threads=self.settings.threads)
            try:
                align(
                    photos.photos,
                    stage.folder,
                    options,
                    self.executor,
                    self.log,
                    features_folder=self.checkpoints.root / FEATURES,
                    earlier_databases=[
                        folder / "database.db" for folder in self.checkpoints.other_folders(stage)
                    ],
                )
            except InputError as error:
                raise error.with_file(self.folder) from error
            stage.finish()
        return Alignment.load(stage.folder), stage

    def _join(
        self, alignment: Alignment, alignment_stage: StageFolder
    ) -> tuple[Alignment, StageFolder]:
        """Join components by markers; other marks are used in the registration."""
        from vomstudio.photogrammetry.georeferencing.joined_alignment import join_alignment

        tables = self.tables
        alignment, stage, findings = join_alignment(
            alignment,
            lambda: self.checkpoints.stage("joined", alignment_stage.key, *tables.hashes),
            tables.points,
            tables.marks,
            self.settings.threads,
            self.log,
        )
        for finding in findings:
            self.log.note(finding)
        return alignment, stage or alignment_stage

    def _place(
        self, alignment: Alignment, photos: PhotoFolder, alignment_stage: StageFolder
    ) -> _RegisteredScene:
        """Register the largest part by control or GPS, or else in a local upright frame."""
        from vomstudio.photogrammetry.pipeline.placing import place_scene

        settings, tables = self.settings, self.tables
        stage = self.checkpoints.stage("frame", alignment_stage.key, settings.crs, *tables.hashes)
        if not stage.is_done:
            self.log.stage(tr("Registering the model"))
            scene, facts = place_scene(alignment, photos.photos, settings, tables, self.log)
            scene.save(stage.folder)
            stage.finish(registration=facts)
        for warning in stage.facts["registration"].get("warnings", []):
            self.log.note(Finding.from_dict(warning))
        if refusal := stage.facts["registration"].get("refused"):
            cause = {"reason": refusal["message"], "reason_code": refusal["code"]}
            self.log.note(Finding("reconstruct.local-frame", **cause))
        return _RegisteredScene(SparseScene.load(stage.folder), stage.facts["registration"], stage)

    def _undistort(
        self, placed_registered: _RegisteredScene, photos: PhotoFolder
    ) -> tuple[PhotoResults[UndistortedPhoto], StageFolder]:
        """Undistort the photos in the size of the depth maps."""
        from vomstudio.photogrammetry.dense import undistortion

        views = placed_registered.scene.views
        size = self._dense_size(placed_registered)
        self.dense_px = size
        stage = self.checkpoints.stage(
            "straight", placed_registered.stage.key, report_data.versions("cv2"), size
        )
        photo_by_name = {photo.name: photo for photo in photos.photos}

        def task(number: int) -> undistortion.UndistortTask:
            photo = photo_by_name[views[number].name]
            mask = None if photo.mask is None else read_bytes(photo.mask)
            return undistortion.UndistortTask(read_bytes(photo.path), mask, views[number], size)

        results = PhotoResults(
            stage.folder, [view.name for view in views], save_undistorted, load_undistorted
        )
        lenses = [view.intrinsics for view in views]
        need = max(undistortion.peak_memory_bytes(n.width, n.height, size) for n in lenses)
        self._compute_missing(
            tr("Undistorting photos"), stage, results, undistortion.undistort, task, need
        )
        return results.at(stage.folder), stage

    def _dense_size(self, placed_registered: _RegisteredScene) -> int:
        """Return the size of depth maps, at most the size used by an earlier run."""
        from vomstudio.photogrammetry.dense.memory_estimate import fitting_size

        requested_px, lenses = (
            self.settings.quality_sizes.dense_px,
            [v.intrinsics for v in placed_registered.scene.views],
        )
        size = fitting_size(requested_px, [(lens.width, lens.height) for lens in lenses])
        stage = self.checkpoints.stage(_SIZE_STAGE, placed_registered.stage.key, requested_px)
        if not stage.is_done:
            stage.finish(dense_px=size)
        size = min(size, int(stage.facts["dense_px"]))
        if size < requested_px:
            self.log.note(Finding("dense.reduced", size_px=size, wanted_px=requested_px))
        return size

    def _depths(
        self,
        scene: SparseScene,
        undistorted: PhotoResults[UndistortedPhoto],
        undistortion_stage: StageFolder,
    ) -> tuple[DepthMapPlans, PhotoResults[DepthMap], StageFolder]:
        from vomstudio.photogrammetry.dense import depthmaps
        from vomstudio.photogrammetry.dense.pairs import select_pairs

        # Within the depths of the rock, the background would be matched at wrong depths.
        pairs = select_pairs(scene)
        if self.region is not None:
            pairs = pairs.select_views(self.region.select_region_views(scene))
        for text in pairs.left_out:
            self.log.note(text)
        names = [scene.views[plan.view].name for plan in pairs.plans]
        if self.device == "cuda":
            versions = report_data.versions("pycolmap")
            stage = self.checkpoints.stage(
                "depths", undistortion_stage.key, versions, "cuda", *self.region_key
            )
            results = PhotoResults(stage.folder, names, _save_depth_map, depthmaps.DepthMap.load)
            if stage.is_done:
                return pairs, results.at(stage.folder), stage
            if compute_gpu_depths(scene, pairs, undistorted, results.put, self.settings, self.log):
                stage.finish()
                return pairs, results.at(stage.folder), stage
            self.device = "cpu"
        versions = report_data.versions("cv2", "numba")
        stage = self.checkpoints.stage("depths", undistortion_stage.key, versions, *self.region_key)

        def task(number: int) -> depthmaps.DepthTask:
            return depthmaps.make_task(pairs.plans[number], undistorted.__getitem__)

        results = PhotoResults(stage.folder, names, _save_depth_map, depthmaps.DepthMap.load)
        lenses = [view.intrinsics for view in scene.views]
        scales = [min(1.0, self.dense_px / max(n.width, n.height)) for n in lenses]
        needed_memory = max(
            depthmaps.peak_memory_bytes(round(n.width * k), round(n.height * k))
            for n, k in zip(lenses, scales, strict=True)
        )
        if not stage.is_done:
            self._reuse_depths(scene, pairs, undistorted, results, stage)
        self._compute_missing(
            tr("Computing depth maps"), stage, results, depthmaps.depth_map, task, needed_memory
        )
        return pairs, results.at(stage.folder), stage

    def _reuse_depths(
        self,
        scene: SparseScene,
        pairs: DepthMapPlans,
        undistorted: PhotoResults[UndistortedPhoto],
        results: PhotoResults[DepthMap],
        stage: StageFolder,
    ) -> None:
        """Reuse depth maps of earlier runs if their cameras moved by less than `MAX_MOVE_PX`.

        The inputs of all maps are stored, so that a later run can do the same.
        """
        rules = make_key(report_data.versions("cv2", "numba"), self.dense_px)
        earlier_maps = EarlierDepthMaps(self.checkpoints.other_folders(stage), rules)
        views = {self.hashes[view.name]: view for view in scene.views}
        reused_count = 0
        for number, plan in enumerate(pairs.plans):
            if results.has(number):
                continue
            pinhole = undistorted[plan.view].view
            photo = self.hashes[scene.views[plan.view].name]
            inputs = DepthInputs.from_plan(plan, scene.views, self.hashes, pinhole)
            if (match := earlier_maps.find(photo, pinhole, views)) is not None:
                depth_map, inputs = match
                results.put(number, depth_map)
                reused_count += 1
            inputs.save(results.path(number).with_suffix(".json"), rules)
        self.log.log(f"{reused_count} of {len(results)} depth maps reused")

    def _compute_missing(
        self,
        title: str,
        stage: StageFolder,
        results: PhotoResults[Result],
        work: Callable[[Item], Result],
        task: Callable[[int], Item],
        needed_bytes: int,
    ) -> None:
        """Compute the missing results of a stage with one result per photo."""
        if stage.is_done:
            return
        missing_numbers = [number for number in range(len(results)) if not results.has(number)]
        self.log.stage(title, len(results))
        progress = ResumedProgress(self.log, len(results) - len(missing_numbers))
        for done_count, result in self.executor.map(
            work, map(task, missing_numbers), progress, needed_bytes
        ):
            results.put(missing_numbers[done_count], result)
        stage.finish()

    def _fuse(
        self,
        scene: SparseScene,
        pairs: DepthMapPlans,
        undistorted: PhotoResults[UndistortedPhoto],
        maps: PhotoResults[DepthMap],
        depth_stage: StageFolder,
    ) -> tuple[PointCloud, StageFolder]:
        from vomstudio.photogrammetry.dense.fusion import fuse_depth_maps, neighbours_by_name

        choice = ["rock"] if self.is_trimmed else []
        stage = self.checkpoints.stage("cloud", depth_stage.key, *choice)
        if not stage.is_done:
            photos = undistorted.select([plan.view for plan in pairs.plans])
            neighbours = neighbours_by_name(scene, pairs)
            cloud = fuse_depth_maps(maps.names, maps, photos, neighbours, progress=self.log)
            if self.region is not None:
                cloud = cloud.select_rows(self.region.contains(cloud.points, scene.origin))
            if self.is_trimmed:
                is_rock = self.rock.contains(scene, cloud.points)
                if is_rock.any():
                    cloud = cloud.select_rows(is_rock)
            write_atomically(stage.folder / _CLOUD_FILE, lambda path: save_cloud(path, cloud))
            stage.finish(points=len(cloud.points))
        return load_result(load_cloud, stage.folder / _CLOUD_FILE), stage

    def _surface(self, cloud: PointCloud, cloud_stage: StageFolder) -> tuple[Mesh, StageFolder]:
        from vomstudio.photogrammetry.surface.meshing import (
            MeshingOptions,
            build_surface,
            max_points_in_memory,
        )

        faces = self.settings.quality_sizes.faces
        stage = self.checkpoints.stage(
            "surface", cloud_stage.key, report_data.versions("open3d"), faces
        )
        if not stage.is_done:
            threads = self.settings.threads or os.cpu_count() or 1
            options = MeshingOptions(
                faces=faces, threads=threads, max_points=max_points_in_memory()
            )
            surface = build_surface(cloud, options, self.log)
            write_atomically(stage.folder / _MESH_FILE, lambda path: save_mesh(path, surface.mesh))
            stage.finish(facts=surface.facts, warnings=list(surface.warnings))
        for warning in stage.facts["warnings"]:
            self.log.note(Finding.from_dict(warning))
        return load_result(load_mesh, stage.folder / _MESH_FILE), stage

    def _texture(
        self,
        mesh: Mesh,
        placed_registered: _RegisteredScene,
        photos: PhotoFolder,
        surfaced: StageFolder,
    ) -> tuple[Mesh, StageFolder]:
        """Compute the texture from original photos, so that nothing is resampled twice."""
        from vomstudio.photogrammetry.surface.atlas import AtlasOptions
        from vomstudio.photogrammetry.surface.texture import (
            TextureOptions,
            encode_jpeg,
            make_texture,
        )

        quality_sizes = self.settings.quality_sizes
        stage = self.checkpoints.stage(
            "texture", surfaced.key, quality_sizes.page_px, quality_sizes.pages
        )
        if not stage.is_done:
            photo_by_name = {photo.name: photo for photo in photos.photos}
            sources = [
                OriginalPhoto(photo_by_name[view.name], view)
                for view in placed_registered.scene.views
            ]
            options = TextureOptions(
                atlas=AtlasOptions(page=quality_sizes.page_px, max_pages=quality_sizes.pages)
            )
            texture = make_texture(mesh, sources, options, self.executor, self.log)
            for material, page in zip(texture.mesh.materials, texture.pages, strict=True):
                picture = encode_jpeg(page)
                path = stage.folder / f"{material.name}.jpg"
                write_atomically(path, lambda p, picture=picture: p.write_bytes(picture))  # type: ignore[misc]
            write_atomically(stage.folder / _MESH_FILE, lambda path: save_mesh(path, texture.mesh))
            stage.finish(report=asdict(texture.report))
        for warning in stage.facts["report"]["warnings"]:
            self.log.note(Finding.from_dict(warning))
        return load_result(load_mesh, stage.folder / _MESH_FILE), stage

    # ------------------------------------------------------------------------------------------
    def _store_request(self) -> None:
        """Store the request, so that an unfinished run can be offered again."""
        request = {"photos": str(self.folder), **self.settings.to_dict()}
        write_atomically(self.outputs.request, lambda path: write_json(path, request))

    def _finish(
        self,
        photos: PhotoFolder,
        alignment: Alignment,
        placed_registered: _RegisteredScene,
        cloud: PointCloud,
        textured_mesh: Mesh,
        dressed: StageFolder,
    ) -> dict[str, Any]:
        from vomstudio.photogrammetry.pipeline.placing import registration_findings

        self.log.end_stage()
        outputs, scene = self.outputs, placed_registered.scene
        for name, reason in alignment.unregistered_photos:
            finding = Finding(
                "alignment.photo-left-out",
                photo=name,
                reason=reason.message,
                reason_code=reason.code,
            )
            self.log.note(finding)
        for part in alignment.parts[1:]:
            names = [view.name for view in part.views]
            self.log.note(Finding("alignment.separate-component", photos=names))
        registration = report_data.add_edge_bowing(
            placed_registered.registration, scene, textured_mesh, self.log.note
        )
        placed_names = {view.name for view in scene.views}
        missing_names = [p.name for p in photos.photos if p.name not in placed_names]
        cameras = report_data.cameras_after_placement(alignment.cameras, scene, registration)
        pose_findings = [] if self.pose_errors is None else self.pose_errors.findings(scene)
        rock_scene = scene.select_points(self.rock.is_rock)
        survey = check_scene(
            rock_scene,
            # Photos of other parts have a pose, and are counted there.
            unregistered_names=[name for name, _ in alignment.unregistered_photos],
            other_parts=alignment.parts[1:],
            cameras=cameras,
            planes=report_data.model_plane_sizes(cloud, textured_mesh, registration),
            other_findings=(*registration_findings(self.settings, registration), *pose_findings),
        )
        rows = report_data.photo_rows(photos.photos, scene, registration, self.rock)
        report_data.add_pose_errors(rows, scene, self.pose_errors)
        for row in rows:
            gain = dressed.facts["report"]["gains"].get(row["name"])
            row["exposure"] = None if gain is None else sum(gain) / 3
        result = {
            "photos": len(photos.photos),
            "registered": len(scene.views),
            "unregistered": missing_names,
            "survey": survey.to_dict(),
            "alignment_notes": to_json_list(alignment.notes),
            "reprojection_error_px": float(alignment.reprojection_error_px),
            "cameras": str(outputs.cameras),
            "sparse": str(outputs.sparse_cloud),
            "dense": str(outputs.dense),
            "mesh": str(outputs.mesh),
            "dense_points": len(cloud.points),
            "faces": len(textured_mesh.faces),
            "frame": scene.crs or "local",
            "scaled": scene.scaled,
            **report_data.sizes(rock_scene, dressed.facts["report"]),
            "device": self.device,
            "seconds": {
                s.name: round(s.seconds, 2)
                for s in self.checkpoints.stages
                if s.name != _SIZE_STAGE
            },
            "peak_memory_mb": round(max(s.peak_bytes for s in self.checkpoints.stages) / 1e6),
            "report": str(outputs.report),
            "poses": str(outputs.poses),
            "folder": str(self.folder),
            "warnings": to_json_list(self.log.notes),
            "tie_points": len(scene.points),
            "tie_points_of_3": int((scene.track_lengths >= 3).sum()),
            "photo_rows": rows,
            **report_data.dense_gsd(rows, self.dense_px),
            "calibration": report_data.calibration(cameras, photos.photos),
            "registration": registration,
            "model": report_data.model(cloud, textured_mesh, dressed.facts["report"]),
            "settings": self.settings.to_dict(),
            "versions": report_data.versions("pycolmap", "open3d", "cv2", "numba"),
            "drawing": report_data.drawing(scene, self.rock),
            "background_share": self.rock.background_share if self.region is None else None,
            "proposed_region": propose_region(scene, self.rock),
        }
        self.checkpoints.record_current()
        result["work_mb"] = round(self.checkpoints.size() / 1e6, 1)
        write_atomically(outputs.result, lambda path: write_json(path, result))
        write_registrations(outputs, result)
        return result


def _save_depth_map(path: Path, depth_map: DepthMap) -> None:
    depth_map.save(path)
