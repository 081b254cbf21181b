import sys; sys.path.insert(0,'/work/main')
import time
from collections import Counter
import numpy as np
from cdpr_interval import load_robot
import solvers.six_dof as sd, solvers.platform_subset as ps
from solvers import forward_kinematics, platform_turn as turn, platform_pose as pose
from solvers.platform_record import look_turn, look_pose
from solvers.platform_scratch import form_arrays
from cdpr_interval.kernels.second_order import ROTATION_ONLY, WHOLE_POSE
from solvers.platform_batch import *
from solvers.platform_elimination import SMALLER
name,ls=sys.argv[1],sys.argv[2].split(',')
keep=[]
orig=ps.SubsetSearch
class Sub(orig):
    def solve(self): super().solve(); keep.append(self)
sd.SubsetSearch=Sub
r=load_robot(name); res=forward_kinematics(r,ls,taut=range(len(ls)))
sub=keep[0]; m=sub.model; n=m.n_taut
ft=form_arrays(ROTATION_ONLY,turn.WIDTH); fp=form_arrays(WHOLE_POSE,pose.P_WIDTH)
states=np.zeros(4,dtype=np.int64); y=np.zeros(6); place=np.zeros((3,2))
piv=m.orders[0,0]
from solvers.platform_starts import rotation_at
roots=[]
for rt in sub.roots:
    z=rt.core.mean(axis=1); R=np.empty((3,3)); rotation_at(z[:3].copy(),R)
    x=z[3:6]-m.anchors[piv]+R@m.points[rt.chart,piv]
    h=(rt.unique[:3,1]-rt.unique[:3,0]).min()/2
    roots.append((rt.chart,z[:3]-h,z[:3]+h,x-h*m.size,x+h*m.size))
    print('root',rt.chart,h, (rt.unique[3:6,1]-rt.unique[3:6,0])/2)
def settled(chart,cell,place):
    for c,ul,uh,xl,xh in roots:
        if c==chart and all(ul[k]<=cell[2*k] and cell[2*k+1]<=uh[k] for k in range(3)) and (xl<=place[:,0]).all() and (place[:,1]<=xh).all(): return True
    return False
cnt=Counter(); reach=float(m.lengths[piv,1]); t0=time.time()
stack=[('u',c.copy()) for c in ps.start_cells(sub.reduction)][::-1]
leaves=[]
while stack:
    kind,c=stack.pop()
    if kind=='u':
        s=look_turn(m,ROTATION_ONLY,ft.forms,ft.work,ft.cells,states,c,y,place)
        w=[c[2*k+1]-c[2*k] for k in range(3)]; k=int(np.argmax(w))
        if s>=16: cnt['u',s]+=1; leaves.append((kind,c,s,y.copy())); continue
        if s==turn.BOTH:
            cnt['sides']+=1
            for b in (-1,1):
                d=c.copy(); d[7]=b; stack.append(('u',d))
            continue
        if s==OPEN and settled(c[6],c,place): cnt['u','root']+=1; leaves.append((kind,c,20,None)); continue
        if s==turn.UNSMOOTH and w[k]<=turn.FOLD_WIDTH:
            cnt['hand on']+=1
            d=np.zeros(14); d[:6]=c[:6]
            for q in range(3): d[6+2*q],d[7+2*q]=-reach,reach
            d[12]=c[6]; stack.append(('x',d)); continue
        if w[k]<1e-5: cnt['small']+=1; continue
        cnt['split']+=1
        mid=0.5*(c[2*k]+c[2*k+1]); a,b=c.copy(),c.copy(); a[2*k+1]=mid; b[2*k]=mid
        stack.append(('u',b)); stack.append(('u',a))
    else:
        before=c.copy()
        s=look_pose(m,WHOLE_POSE,fp.forms,fp.work,fp.cells,states,c,y,place)
        if s>=16: cnt['x',s]+=1; leaves.append((kind,before,s,y.copy())); continue
        if s==SMALLER: cnt['cut']+=1; stack.append(('x',c)); continue
        pl=np.array([[c[6+2*q],c[7+2*q]] for q in range(3)])
        if settled(c[12],c,pl): cnt['x','root']+=1; continue
        w=[(c[2*k+1]-c[2*k])*(1 if k<3 else .4/m.size) for k in range(6)]; k=int(np.argmax(w))
        if w[k]<1e-5: cnt['xsmall']+=1; continue
        cnt['xsplit']+=1
        mid=0.5*(c[2*k]+c[2*k+1]); a,b=c.copy(),c.copy(); a[2*k+1]=mid; b[2*k]=mid
        stack.append(('x',b)); stack.append(('x',a))
print(cnt, len(leaves), time.time()-t0)
np.save(f'/tmp/p/cert/{name}.npy',np.array([np.concatenate([[0 if k=='u' else 1,s],np.pad(c,(0,14-len(c))),y if y is not None else np.zeros(6)]) for k,c,s,y in leaves]))
