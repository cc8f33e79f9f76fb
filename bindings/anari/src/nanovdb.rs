// SPDX-License-Identifier: GPL-3.0-or-later
//! Grids of NanoVDB in memory, as dense values.
//! Source: the layout of versions 32.x: a header of 672 bytes, a tree of 64, and nodes of 32^3, 16^3 and 8^3 children; tables have x
//! first, offsets count from the node that has them. Space: index.
//! Invariant: nothing is read beyond the bytes, and the size of the box is checked before memory is taken. Tests: `tests`;
//! tests/nanovdb_judge.cpp compares with NanoVDB's own reader.

/// Values of a box, at most: 2^29.
const MOST: u64 = 1 << 29;
/// Bytes of the grid's header; the tree's follows.
const TREE: usize = 672;
const MAP: usize = 296;
const KIND: usize = 636;

/// Kinds of values, as the header numbers them.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Kind {
    Float,
    Double,
    /// Codes of so many bits between two floats.
    Fixed(u32),
    /// The same, each leaf with bits of its own.
    Varied,
}

/// Values in a box, x fastest.
#[derive(Debug, PartialEq)]
pub(crate) struct Dense {
    /// Values along each axis.
    pub(crate) dims: [usize; 3],
    /// Place of the first value, object space.
    pub(crate) origin: [f32; 3],
    /// From value to value, object space.
    pub(crate) spacing: [f32; 3],
    pub(crate) values: Vec<f32>,
}

/// The bytes of a grid.
#[derive(Clone, Copy)]
struct Bytes<'b>(&'b [u8]);

impl<'b> Bytes<'b> {
    fn take<const N: usize>(self, at: usize) -> Result<[u8; N], String> {
        let bytes = at.checked_add(N).and_then(|end| self.0.get(at..end));
        bytes.and_then(|bytes| bytes.try_into().ok()).ok_or_else(|| format!("it ends before byte {at}"))
    }

    fn u32(self, at: usize) -> Result<u32, String> {
        Ok(u32::from_le_bytes(self.take(at)?))
    }

    fn i32(self, at: usize) -> Result<i32, String> {
        Ok(i32::from_le_bytes(self.take(at)?))
    }

    fn u64(self, at: usize) -> Result<u64, String> {
        Ok(u64::from_le_bytes(self.take(at)?))
    }

    fn f32(self, at: usize) -> Result<f32, String> {
        Ok(f32::from_le_bytes(self.take(at)?))
    }

    fn f64(self, at: usize) -> Result<f64, String> {
        Ok(f64::from_le_bytes(self.take(at)?))
    }

    /// A value of internal nodes.
    fn value(self, at: usize, kind: Kind) -> Result<f32, String> {
        if kind == Kind::Double { Ok(self.f64(at)? as f32) } else { self.f32(at) }
    }

    /// Bit `index` of a mask.
    fn bit(self, mask: usize, index: usize) -> Result<bool, String> {
        Ok(self.take::<1>(mask + index / 8)?[0] >> (index % 8) & 1 == 1)
    }

    /// Where the node is that an entry at `at` leads to from `from`.
    fn child(self, from: usize, at: usize) -> Result<usize, String> {
        let offset = i64::from_le_bytes(self.take(at)?);
        let target = usize::try_from(offset).ok().and_then(|offset| from.checked_add(offset));
        target
            .filter(|_| offset > 0)
            .ok_or_else(|| format!("the node at byte {from} has a wrong offset, {offset}"))
    }
}

/// The box that is filled.
struct Box3 {
    low: [i64; 3],
    dims: [usize; 3],
    values: Vec<f32>,
    /// Nodes that may still be read.
    nodes: usize,
}

impl Box3 {
    /// Counts a node: those that several entries share would be read again and again.
    fn enter(&mut self, at: usize) -> Result<(), String> {
        self.nodes = self.nodes.checked_sub(1).ok_or_else(|| format!("nodes overlap at byte {at}"))?;
        Ok(())
    }

    /// Gives all values of a cube with an edge of `size` the same value.
    fn fill(&mut self, origin: [i64; 3], size: i64, value: f32) {
        let range = |k: usize| {
            let within = |x: i64| (x - self.low[k]).clamp(0, self.dims[k] as i64) as usize;
            within(origin[k])..within(origin[k] + size)
        };
        let [xs, ys, zs] = [range(0), range(1), range(2)];
        for z in zs {
            for y in ys.clone() {
                let row = self.dims[0] * (y + self.dims[1] * z);
                self.values[row + xs.start..row + xs.end].fill(value);
            }
        }
    }
}

/// Internal nodes: the logarithms of their children's number along an axis and of their own values'.
#[derive(Clone, Copy)]
struct Level {
    log: usize,
    total: usize,
}

const UPPER: Level = Level { log: 5, total: 12 };
const LOWER: Level = Level { log: 4, total: 7 };
const LEAF_LOG: usize = 3;

/// Reads the nodes below one of a level.
fn node(
    bytes: Bytes,
    at: usize,
    level: Level,
    origin: [i64; 3],
    kind: Kind,
    out: &mut Box3,
) -> Result<(), String> {
    out.enter(at)?;
    let count = 1_usize << (3 * level.log);
    let children = at + 32 + count / 8;
    let width = if kind == Kind::Double { 8 } else { 4 };
    let table = at + (32 + count / 4 + 4 * width).next_multiple_of(32);
    let size = 1_i64 << (level.total - level.log);
    for index in 0..count {
        let has_child = bytes.bit(children, index)?;
        let mask = (1 << level.log) - 1;
        let step = [index >> (2 * level.log), index >> level.log & mask, index & mask];
        let place = std::array::from_fn(|k| origin[k] + step[k] as i64 * size);
        let entry = table + 8 * index;
        if !has_child {
            out.fill(place, size, bytes.value(entry, kind)?);
        } else if level.log == UPPER.log {
            node(bytes, bytes.child(at, entry)?, LOWER, place, kind, out)?;
        } else {
            leaf(bytes, bytes.child(at, entry)?, place, kind, out)?;
        }
    }
    Ok(())
}

fn leaf(bytes: Bytes, at: usize, origin: [i64; 3], kind: Kind, out: &mut Box3) -> Result<(), String> {
    out.enter(at)?;
    let (minimum, quantum) = (bytes.f32(at + 80)?, bytes.f32(at + 84)?);
    let bits = match kind {
        Kind::Fixed(bits) => bits,
        // The logarithm of the bits.
        Kind::Varied => 1 << (bytes.take::<1>(at + 15)?[0] >> 5).min(4),
        Kind::Float | Kind::Double => 0,
    };
    for index in 0..512_usize {
        let step = [index >> (2 * LEAF_LOG), index >> LEAF_LOG & 7, index & 7];
        let value = match kind {
            Kind::Float => bytes.f32(at + 96 + 4 * index)?,
            Kind::Double => bytes.f64(at + 128 + 8 * index)? as f32,
            _ => {
                let first = index * bits as usize;
                let word = bytes.u32(at + 96 + first / 32 * 4)?;
                let code = word >> (first % 32) & ((1_u64 << bits) - 1) as u32;
                code as f32 * quantum + minimum
            }
        };
        out.fill(std::array::from_fn(|k| origin[k] + step[k] as i64), 1, value);
    }
    Ok(())
}

/// The values of a grid around its active ones, also of inactive tiles between them; an error in words where it is none, or damaged.
pub(crate) fn dense(bytes: &[u8]) -> Result<Dense, String> {
    let bytes = Bytes(bytes);
    if !matches!(&bytes.take::<8>(0)?, b"NanoVDB0" | b"NanoVDB1") {
        return Err("it does not begin as a grid of NanoVDB".into());
    }
    let version = bytes.u32(16)?;
    if version >> 21 != 32 {
        return Err(format!("version {} of NanoVDB: unsupported; allowed: 32", version >> 21));
    }
    let kind = match bytes.u32(KIND)? {
        1 => Kind::Float,
        2 => Kind::Double,
        13 => Kind::Fixed(4),
        14 => Kind::Fixed(8),
        15 => Kind::Fixed(16),
        16 => Kind::Varied,
        other => {
            return Err(format!("values of type {other}: unsupported; allowed: floats, doubles, Fp4 to FpN"));
        }
    };
    let [map, shift] = [MAP + 88, MAP + 88 + 144];
    let mut matrix = [0.0; 9];
    for (k, x) in matrix.iter_mut().enumerate() {
        *x = bytes.f64(map + 8 * k)?;
    }
    let scale = [matrix[0], matrix[4], matrix[8]];
    let largest = scale.iter().copied().fold(0.0, f64::max);
    let is_straight = [1, 2, 3, 5, 6, 7].iter().all(|&k: &usize| matrix[k].abs() <= 1e-6 * largest);
    if !is_straight || !scale.iter().all(|x| *x > 0.0 && x.is_finite()) {
        return Err("its transform turns or mirrors, which is unsupported".into());
    }
    let root = usize::try_from(bytes.u64(TREE + 24)?).ok().and_then(|offset| TREE.checked_add(offset));
    let root = root.ok_or("the tree has no root")?;
    let (mut low, mut dims, mut count) = ([0; 3], [0; 3], 1_u64);
    for k in 0..3 {
        // One more on each side, so that values fall to the background.
        low[k] = i64::from(bytes.i32(root + 4 * k)?) - 1;
        let cells = i64::from(bytes.i32(root + 12 + 4 * k)?) + 2 - low[k];
        if cells < 3 {
            return Err("it has no values".into());
        }
        count = count.saturating_mul(cells as u64);
        dims[k] = cells as usize;
    }
    if count > MOST {
        return Err(format!("its box of {} x {} x {} values: more than {MOST}", dims[0], dims[1], dims[2]));
    }
    let wide = kind == Kind::Double;
    let background = bytes.value(root + if wide { 32 } else { 28 }, kind)?;
    // The smallest node has 96 bytes.
    let nodes = bytes.0.len() / 96;
    let mut out = Box3 { low, dims, values: vec![background; count as usize], nodes };
    let first = root + if wide { 96 } else { 64 };
    for tile in 0..bytes.u32(root + 24)? as usize {
        let at = first + 32 * tile;
        let key = bytes.u64(at)?;
        // Twelve bits less of each coordinate, whose signs come back by the shift.
        let origin = [42, 21, 0]
            .map(|bits| i64::from(((key >> bits & 0x1f_ffff) as u32) << UPPER.total) as i32 as i64);
        if bytes.u64(at + 8)? != 0 {
            node(bytes, bytes.child(root, at + 8)?, UPPER, origin, kind, &mut out)?;
        } else {
            out.fill(origin, 1 << UPPER.total, bytes.value(at + if wide { 24 } else { 20 }, kind)?);
        }
    }
    let mut origin = [0.0; 3];
    for k in 0..3 {
        origin[k] = (scale[k] * low[k] as f64 + bytes.f64(shift + 8 * k)?) as f32;
    }
    Ok(Dense { dims, origin, spacing: scale.map(|x| x as f32), values: out.values })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A grid of floats by the layout above: a leaf whose values are those of `f`, a tile of 8^3 beside it, and one of 128^3 in another
    /// upper node. Values are at 0.5 times their index and 10 aside.
    fn grid(f: impl Fn([i64; 3]) -> f32, low: [i32; 3], high: [i32; 3]) -> Vec<u8> {
        let [root, upper, lower, leaf] =
            [64, 64 + 64 + 64, 64 + 64 + 64 + 270_400, 64 + 64 + 64 + 270_400 + 33_856];
        let second = leaf + 2144;
        let mut bytes = vec![0_u8; TREE + second + 270_400];
        let mut put = |at: usize, data: &[u8]| bytes[at..at + data.len()].copy_from_slice(data);
        put(0, b"NanoVDB0");
        put(16, &(32_u32 << 21 | 3 << 10).to_le_bytes());
        for k in 0..3 {
            put(MAP + 88 + 32 * k, &0.5_f64.to_le_bytes());
            put(MAP + 88 + 144 + 8 * k, &10_f64.to_le_bytes());
        }
        put(KIND, &1_u32.to_le_bytes());
        put(TREE + 24, &(root as u64).to_le_bytes());
        let root = TREE + root;
        for k in 0..3 {
            put(root + 4 * k, &low[k].to_le_bytes());
            put(root + 12 + 4 * k, &high[k].to_le_bytes());
        }
        put(root + 24, &2_u32.to_le_bytes());
        put(root + 28, &(-1_f32).to_le_bytes());
        // Tiles: the upper node at the origin, and that at (-4096, 0, 0).
        let key = |x: i32| u64::from(x as u32 >> 12) << 42;
        put(root + 64, &key(0).to_le_bytes());
        put(root + 72, &((TREE + upper - root) as u64).to_le_bytes());
        put(root + 96, &key(-4096).to_le_bytes());
        put(root + 104, &((TREE + second - root) as u64).to_le_bytes());
        // Its last child along x is a tile, as all are that have no node.
        let (second, index) = (TREE + second, 31 << 10);
        put(second + 8256 + 8 * index, &7_f32.to_le_bytes());
        let (upper, lower, leaf) = (TREE + upper, TREE + lower, TREE + leaf);
        put(upper + 32 + 4096, &[1]);
        put(upper + 8256, &((lower - upper) as u64).to_le_bytes());
        // A leaf, and a tile behind it along z.
        put(lower + 32 + 512, &[1]);
        put(lower + 1088, &((leaf - lower) as u64).to_le_bytes());
        put(lower + 1096, &5_f32.to_le_bytes());
        for index in 0..512 {
            let place = [index >> 6, index >> 3 & 7, index & 7].map(|x| x as i64);
            put(leaf + 96 + 4 * index, &f(place).to_le_bytes());
        }
        bytes
    }

    #[test]
    fn values_are_where_nodes_have_them() {
        let f = |[x, y, z]: [i64; 3]| (100 * x + 10 * y + z) as f32;
        let found = dense(&grid(f, [-2, 0, 0], [7, 7, 9])).expect("a grid");
        assert_eq!((found.dims, found.origin, found.spacing), ([12, 10, 12], [8.5, 9.5, 9.5], [0.5; 3]));
        for (index, &value) in found.values.iter().enumerate() {
            let [x, y, z] = [index % 12, index / 12 % 10, index / 120].map(|x| x as i64);
            let (x, y, z) = (x - 3, y - 1, z - 1);
            let expected = match (x, y, z) {
                (-3..0, 0.., 0..) => 7.0,
                (0..8, 0..8, 0..8) => f([x, y, z]),
                (0..8, 0..8, 8..) => 5.0,
                (_, 0.., 0..) => 0.0,
                _ => -1.0,
            };
            assert_eq!(value, expected, "at {x}, {y}, {z}");
        }
    }

    #[test]
    fn damaged_grids_are_errors() {
        let whole = grid(|_| 1.0, [0; 3], [7; 3]);
        let error = |edit: &dyn Fn(&mut Vec<u8>)| {
            let mut bytes = whole.clone();
            edit(&mut bytes);
            dense(&bytes).expect_err("it is damaged")
        };
        for cut in [0, 7, 300, TREE + 10, TREE + 64 + 70, whole.len() - 270_400 - 100] {
            assert!(error(&|bytes| bytes.truncate(cut)).contains("ends before"), "cut at {cut}");
        }
        let root = TREE + 64;
        for (edit, words) in [
            (&(|bytes: &mut Vec<u8>| bytes[0] = 0) as &dyn Fn(&mut Vec<u8>), "begin as a grid"),
            (&|bytes| bytes[19] = 0xff, "version"),
            (&|bytes| bytes[KIND] = 6, "values of type 6"),
            (&|bytes| bytes[MAP + 88 + 8..MAP + 88 + 16].copy_from_slice(&1_f64.to_le_bytes()), "turns"),
            (&|bytes| bytes[root + 12..root + 16].copy_from_slice(&i32::MAX.to_le_bytes()), "more than"),
            (&|bytes| bytes[root + 12..root + 16].copy_from_slice(&(-9_i32).to_le_bytes()), "no values"),
            (&|bytes| bytes[root + 79] = 0x80, "wrong offset"),
        ] {
            let found = error(edit);
            assert!(found.contains(words), "{found}, not {words}");
        }
    }

    /// Grids and values in the folder `GNURT_NANOVDB`, as tests/nanovdb_judge.cpp writes them.
    #[test]
    #[ignore = "needs the files of tests/nanovdb_judge.cpp"]
    fn values_are_those_of_nanovdbs_own_reader() {
        let folder =
            std::path::PathBuf::from(std::env::var_os("GNURT_NANOVDB").expect("GNURT_NANOVDB=FOLDER"));
        for name in ["float", "double", "fp4", "fp8", "fp16", "fpn"] {
            let read = |end: &str| std::fs::read(folder.join(format!("{name}.{end}"))).expect("a file");
            let found = dense(&read("grid")).expect("a grid");
            let expected = read("values");
            let expected = expected.chunks_exact(4).map(|b| f32::from_le_bytes([b[0], b[1], b[2], b[3]]));
            assert_eq!(expected.len(), found.values.len(), "{name}: {:?}", found.dims);
            for (i, (&found, expected)) in found.values.iter().zip(expected).enumerate() {
                assert!((found - expected).abs() < 1e-6, "{name}: value {i} is {found}, not {expected}");
            }
            let step = found.spacing.map(|x| (x - 0.25).abs());
            assert!(step.iter().all(|off| *off < 1e-6), "{name}: {:?}", found.spacing);
        }
    }
}
